// Stable neo-Hookean flesh: Smith, de Goes, Kim, "Stable Neo-Hookean Flesh Simulation", ACM TOG 37(2), 2018.
//   energy = mu/2 (I_C - 3) + lambda/2 (J - alpha)^2 - mu/2 log(I_C + 1),    I_C = |F|^2, J = det F
// No logarithm of J and no inverse of F: finite for flat and inverted elements. alpha makes the rest state free of
// stress; mu and lambda are those of the paper's section 3.4, so that small strains agree with Hooke's law.
#include <Eigen/Eigenvalues>
#include <cmath>

#include "models/fem/lane_material.hpp"
#include "models/fem/lane_svd.hpp"

namespace kt {
namespace {

/// out += diagonal I + [axis]x.
void add_identity_and_cross(const Lanes& diagonal, const LaneVec3& axis, LaneMat3& out) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    out(i, i) += diagonal;
    out(k, j) += axis[i];
    out(j, k) -= axis[i];
  }
}

class NeoHookean final : public LaneMaterial<NeoHookean> {
 public:
  explicit NeoHookean(const Lame& lame)
      : mu_(4.0 / 3.0 * lame.mu), lambda_(lame.lambda + 5.0 / 6.0 * lame.mu), alpha_(1 + 0.75 * mu_ / lambda_) {
    rest_ = density(3, 1);
  }
  double energy(const Mat3& F) const override { return density(F.squaredNorm(), F.determinant()) - rest_; }
  template <class T>
  Mat3Of<T> stress_of(const Mat3Of<T>& F) const {
    const Parts<T> p = parts(F);
    return p.a * F + p.c * p.cofactor;
  }
  Mat9 tangent(const Mat3& F) const override {
    const Parts<double> p = parts(F);
    Mat9 out = p.c * cofactor_tangent(F);
    out.diagonal().array() += p.a;
    out += (p.b * flat(F)) * flat(F).transpose() + (lambda_ * flat(p.cofactor)) * flat(p.cofactor).transpose();
    return out;
  }
  /// a (g_a.g_b) I + b (F g_a)(F g_b)^T + lambda (C g_a)(C g_b)^T - c [F (g_a x g_b)]x with C the cofactors and a, b, c
  /// as in Parts. What is indefinite is lifted eigenvalue by eigenvalue.
  void add_stiffness_to(const LaneStiffness& s) const {
    const auto& [F, definite, g, volume, blocks] = s;
    const Parts<Lanes> p = parts(F);
    const PerNode f = per_node(F, g), cof = per_node(p.cofactor, g);
    auto block = blocks.begin();
    for (std::size_t b = 1; b < g.size(); ++b) {
      const LaneVec3 gb = volume * g[b], ab = p.a * gb, cb = p.c * gb;
      const LaneVec3 bf = (p.b * volume) * f[b], lambda_cof = (Lanes(lambda_) * volume) * cof[b];
      for (std::size_t a = 0; a < b; ++a, ++block) {
        for (int i = 0; i < 3; ++i) block->col(i) += bf[i] * f[a] + lambda_cof[i] * cof[a];
        add_identity_and_cross(g[a].dot(ab), F * cb.cross(g[a]), *block);
      }
    }
    if (definite && !is_definite(p, F)) add_lift(p, F, g, volume, blocks);
  }

 private:
  /// dP/dF = a I + b F F^T + lambda C C^T + c d2J/dF2, all as vectors of nine.
  template <class T>
  struct Parts {
    Mat3Of<T> cofactor;
    T J, I, a, b, c;
  };
  template <class T>
  Parts<T> parts(const Mat3Of<T>& F) const {
    Parts<T> p;
    p.cofactor = cofactor(F);
    p.J = F.col(0).dot(p.cofactor.col(0));
    p.I = F.squaredNorm();
    const T share = T(1) / (p.I + T(1));
    p.a = T(mu_) * (T(1) - share);
    p.b = T(2 * mu_) * share * share;
    p.c = T(lambda_) * (p.J - T(alpha_));
    return p;
  }

  /// In the frame of the principal stretches, F = U diag(s) V^T, the tangent splits (Smith et al., section 4): for each
  /// pair i, j of axes eigenvalues a - c s_k of dP = U (e_i e_j^T + e_j e_i^T) V^T and a + c s_k with minus between;
  /// and a 3 x 3 block of dP = U diag V^T. The six are not negative when a^2 I - c^2 F^T F has no negative minor; the
  /// block is judged by its elementary symmetric functions, which are polynomials in the invariants of F.
  bool is_definite(const Parts<Lanes>& p, const LaneMat3& F) const {
    using T = Lanes;
    constexpr double kRoundoff = 1e-12;
    const LaneMat3 W = (p.a * p.a * (1 + kRoundoff)) * LaneMat3::Identity() - (p.c * p.c) * (F.transpose() * F);
    if (!kt::is_definite(W)) return false;
    const T a = p.a, b = p.b, L = lambda_, k = L * p.J + p.c;  // off the diagonal: b s_i s_j + k s_k
    const T I1 = p.I, I2 = p.cofactor.squaredNorm(), J = p.J, J2 = J * J;
    const T q2 = I1 * I1 - 2 * I2, m2 = I2 * I2 - 2 * I1 * J2;  // sums of s_i^4, of (s_j s_k)^4
    const T e1 = 3 * a + b * I1 + L * I2;
    const T diagonal2 = 3 * a * a + b * b * q2 + L * L * m2 + 2 * a * b * I1 + 2 * a * L * I2 + 6 * b * L * J2;
    const T off2 = b * b * I2 + 6 * b * k * J + k * k * I1;
    const T e2 = 0.5 * (e1 * e1 - diagonal2) - off2;
    const T diagonals = a * a * a + a * a * (b * I1 + L * I2) +
                        a * (b * b * I2 + L * L * I1 * J2 + b * L * (I1 * I2 - 3 * J2)) + b * b * b * J2 +
                        b * b * L * m2 + b * L * L * J2 * q2 + L * L * L * J2 * J2;
    const T offs = J * (b * b * b * J + b * b * k * I1 + k * k * k) + b * k * k * I2;
    const T mixed = a * off2 + b * (3 * b * b * J2 + 2 * b * k * J * I1 + k * k * q2) +
                    L * (b * b * m2 + 2 * b * k * J * I2 + 3 * k * k * J2);
    return none_negative(e1) && none_negative(e2) && none_negative(diagonals + 2 * offs - mixed);
  }

  /// What sets the negative eigenvalues to zero, in the frame of the stretches: with q = V^T g
  ///   lift(i, i) = sum_j even_ij q_aj q_bj,   lift(i, j) = odd_ij q_aj q_bi  and  stretch_ij q_ai q_bj  to both.
  void add_lift(const Parts<Lanes>& p, const LaneMat3& F, std::span<const LaneVec3> g, const Lanes& volume,
                std::span<LaneMat3> blocks) const {
    const LaneSvd svd = singular_values(F);
    LaneMat3 even, odd, stretch = stretch_lift(p, svd.s);
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      const Lanes symmetric = positive_part(p.c * svd.s[k] - p.a), skew = positive_part(-p.a - p.c * svd.s[k]);
      even(i, j) = even(j, i) = 0.5 * (symmetric + skew);
      odd(i, j) = odd(j, i) = 0.5 * (symmetric - skew);
    }
    const PerNode q = per_node(svd.V.transpose(), g);
    auto block = blocks.begin();
    for (std::size_t b = 1; b < g.size(); ++b) {
      const LaneVec3 qb = volume * q[b];
      for (std::size_t a = 0; a < b; ++a, ++block) {
        LaneMat3 lift;
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) lift(i, j) = stretch(i, j) * q[a][i] * qb[j];
        for (int k = 0; k < 3; ++k) {
          const int i = (k + 1) % 3, j = (k + 2) % 3;
          lift(i, i) += even(i, j) * q[a][j] * qb[j];
          lift(j, j) += even(i, j) * q[a][i] * qb[i];
          lift(i, j) += odd(i, j) * q[a][j] * qb[i];
          lift(j, i) += odd(i, j) * q[a][i] * qb[j];
        }
        *block += svd.U * lift * svd.U.transpose();
      }
    }
  }
  LaneMat3 stretch_lift(const Parts<Lanes>& p, const LaneVec3& s) const {
    LaneMat3 block;
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      block(k, k) = p.a + p.b * s[k] * s[k] + lambda_ * s[i] * s[i] * s[j] * s[j];
      block(i, j) = block(j, i) = p.b * s[i] * s[j] + (lambda_ * s[0] * s[1] * s[2] + p.c) * s[k];
    }
    LaneMat3 out = LaneMat3::Zero();
    if (kt::is_definite(block)) return out;
    for (int lane = 0; lane < Lanes::kCount; ++lane) {
      const Mat3 one = get_lane(block, lane);
      const Eigen::SelfAdjointEigenSolver<Mat3> eigen(one);
      set_lane(out, lane,
               Mat3(eigen.eigenvectors() * (-eigen.eigenvalues()).cwiseMax(0).asDiagonal() *
                    eigen.eigenvectors().transpose()));
    }
    return out;
  }

  double density(double I_C, double J) const {
    return 0.5 * (mu_ * (I_C - 3) + lambda_ * (J - alpha_) * (J - alpha_) - mu_ * std::log(I_C + 1));
  }
  double mu_, lambda_, alpha_, rest_;
};

}  // namespace

std::unique_ptr<Material> make_neo_hookean_material(const Lame& lame) { return std::make_unique<NeoHookean>(lame); }

}  // namespace kt
