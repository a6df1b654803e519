#include "haptics/contact/contact_newton.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace kt {
namespace {

constexpr double kSingular = 1e-10;  // added to a matrix of ones' size: contacts can be one
constexpr double kTouches = 1e-9;    // of the largest velocity: an overlap is less

}  // namespace

/// Impulses with u = 0 where it sticks and u_m = 0 where it slides, along the given directions; zero where it is free.
bool ContactNewton::solve(const ContactSystem& system, std::span<const ContactMode> mode,
                          std::span<const Vec3> direction, Vector& out) noexcept {
  const int c = system.count();
  using Block = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3>;
  std::array<Block, kMost> of, along;  // unknowns and equations of each contact
  std::array<int, kMost> at;
  int n = 0;
  for (int i = 0; i < c; ++i) {
    at[i] = n;
    if (mode[i] == ContactMode::free) {
      of[i].resize(3, 0);
      along[i].resize(3, 0);
    } else if (mode[i] == ContactMode::stick) {
      of[i] = along[i] = Mat3::Identity();
    } else {
      of[i] = direction[i];
      along[i] = -system.normal[i];
    }
    n += static_cast<int>(of[i].cols());
  }
  matrix_.resize(n, n);
  right_.resize(n);
  for (int i = 0; i < c; ++i) {
    const double r = system.mass(i);
    const Eigen::Index rows = along[i].cols();
    right_.segment(at[i], rows) = -r * (along[i].transpose() * system.velocity.segment<3>(3 * i));
    for (int k = 0; k < c; ++k)
      matrix_.block(at[i], at[k], rows, of[k].cols()) =
          r * (along[i].transpose() * system.W.block<3, 3>(3 * i, 3 * k) * of[k]);
  }
  matrix_.diagonal().array() += kSingular;
  if (n > 0) right_ = matrix_.partialPivLu().solve(right_).eval();
  out.resize(3 * c);
  for (int i = 0; i < c; ++i) out.segment<3>(3 * i) = of[i] * right_.segment(at[i], of[i].cols());
  return out.allFinite();
}

bool ContactNewton::pivot(const ContactSystem& system, int most_changes, std::span<const double> mu,
                          std::span<const ContactMode> start, Eigen::Ref<VectorX> impulse, ContactWork& work) noexcept {
  const int c = system.count();
  std::array<ContactMode, kMost> mode;
  std::array<Vec3, kMost> direction;
  for (int i = 0; i < c; ++i) {
    const Vec3 m = -system.normal[i], p = impulse.segment<3>(3 * i);
    const double p_m = m.dot(p);
    mode[i] = start[i];
    direction[i] = p_m > 0 ? Vec3(p / p_m) : m;
  }
  const double speed = system.velocity.lpNorm<Eigen::Infinity>();
  Vector p;
  for (int change = 0; change <= most_changes && !work.is_over(); ++change) {
    work.take_factor(3 * c);
    work.take(2 * system.W.size());
    if (!solve(system, std::span(mode).first(static_cast<std::size_t>(c)), direction, p)) return false;
    int weakest = -1, thrown = -1, deepest = -1;
    double least = 0, lowest = -kTouches * speed;
    for (int i = 0; i < c; ++i) {
      const Vec3 m = -system.normal[i], own = p.segment<3>(3 * i);
      const double p_m = m.dot(own);
      if (p_m < least) {
        least = p_m;
        weakest = i;
      }
      if (mode[i] == ContactMode::stick && (own - p_m * m).norm() > (1 + kTouches) * mu[i] * p_m) thrown = i;
      const double u_m =
          m.dot(system.velocity.segment<3>(3 * i) + system.W.middleRows<3>(3 * i) * p);  // of contacts that are free
      if (mode[i] == ContactMode::free && u_m < lowest) {
        lowest = u_m;
        deepest = i;
      }
    }
    if (weakest >= 0) {
      mode[weakest] = ContactMode::free;
    } else if (thrown >= 0) {
      const Vec3 m = -system.normal[thrown], own = p.segment<3>(3 * thrown), p_t = own - m.dot(own) * m;
      mode[thrown] = ContactMode::frictional_slide;
      direction[thrown] = m + mu[thrown] * p_t.normalized();
    } else if (deepest >= 0) {
      mode[deepest] = ContactMode::slide;
      direction[deepest] = -system.normal[deepest];
    } else {
      impulse = p;
      return true;
    }
  }
  return false;
}

bool ContactNewton::step(const ContactSystem& system, std::span<const double> mu, Eigen::Ref<VectorX> impulse,
                         ContactWork& work) noexcept {
  work.take_factor(3 * system.count());
  work.take(4 * system.W.size());
  const int c = system.count();
  matrix_.resize(3 * c, 3 * c);
  right_.resize(3 * c);
  for (int i = 0; i < c; ++i) {
    const double r = system.mass(i);
    const Vec3 m = -system.normal[i], p = impulse.segment<3>(3 * i);
    const Vec3 u = system.velocity.segment<3>(3 * i) + system.W.middleRows<3>(3 * i) * impulse;
    const Vec3 y = p - r * u;
    const double y_m = m.dot(y);
    const Vec3 y_t = y - y_m * m;
    const double length = y_t.norm(), cone = mu[i] * y_m;
    const Mat3 on_surface = Mat3::Identity() - m * m.transpose();
    // Row of the matrix: by_velocity W + by_impulse.
    Mat3 by_velocity = Mat3::Zero(), by_impulse = Mat3::Zero();
    Vec3 value;
    if (y_m <= 0 || r == 0) {
      value = p;
      by_impulse.setIdentity();
    } else if (length <= cone) {
      value = r * u;
      by_velocity = r * Mat3::Identity();
    } else {
      const Vec3 d = y_t / length;
      const Mat3 turn = cone / length * (on_surface - d * d.transpose());
      value = r * m.dot(u) * m + on_surface * p - cone * d;
      by_velocity = r * (m * m.transpose() + mu[i] * d * m.transpose() + turn);
      by_impulse = on_surface - mu[i] * d * m.transpose() - turn;
    }
    matrix_.middleRows<3>(3 * i).noalias() = by_velocity * system.W.middleRows<3>(3 * i);
    matrix_.block<3, 3>(3 * i, 3 * i) += by_impulse + kSingular * Mat3::Identity();
    right_.segment<3>(3 * i) = -value;
  }
  right_ = matrix_.partialPivLu().solve(right_).eval();
  if (!right_.allFinite()) return false;
  impulse += right_;
  return true;
}

}  // namespace kt
