#include "core/local/graded_body.hpp"

#include <Eigen/LU>
#include <numbers>

#include "core/base/error.hpp"
#include "core/base/stages.hpp"
#include "core/linear/dense/dense_product.hpp"
#include "core/linear/dense/orthonormalizer.hpp"

namespace kt {
namespace {

// Of improving far motions: of a new body. Of new kept nodes two turns do, of one step: the motions are the whole
// body's.
constexpr int kSetUpTurns = 24, kTurnsAnew = 2;
constexpr int kSetUpSteps = 3, kSteps = 1;  // of conjugate gradients in each

// Around where a patch is going nodes are kept, too: it goes on as far as it came since they were chosen last, twice,
// and no further than so many edges of it.
constexpr double kAhead = 2, kFurthest = 2;

double square(double x) { return x * x; }

Vec3 middle(const VectorX& x, const std::vector<int>& nodes) {
  Vec3 sum = Vec3::Zero();
  for (int i : nodes) sum += node(x, i);
  return sum / static_cast<double>(nodes.size());
}

}  // namespace

/// The patch stays a spacing inside of where all nodes are kept.
bool GradedBody::covers(const TangentModel& tangent, const SurfacePatch& patch) const {
  if (gradings_ == 0 || graded_x_.size() != tangent.state.x.size()) return false;
  // A large patch can make a body whole that a smaller one need not.
  if (whole_) return 2 * patch.global_node.size() >= graded_patch_.size();
  const double inside = std::max(0.0, options_.margin - 1) * edge_;
  return std::all_of(patch.global_node.begin(), patch.global_node.end(), [&](int i) {
    return (fixed_[i] || body_.dofs.to_free[3 * i] >= 0) && distance_to(graded_x_, graded_patch_, i) <= inside;
  });
}

void GradedBody::choose_nodes(const TangentModel& tangent, const SurfacePatch& patch) {
  const int n = static_cast<int>(tangent.f0.size() / 3);
  ++gradings_;
  // A patch that has left where it was goes on: what lies on its way is kept as well.
  const bool moved = graded_x_.size() == tangent.state.x.size() && !graded_patch_.empty();
  const Stage stage("grading: nodes chosen anew");
  graded_x_ = tangent.state.x;
  edge_ = patch_spacing(graded_x_, patch.global_node);
  Vec3 ahead = Vec3::Zero();
  if (moved) ahead = kAhead * (middle(graded_x_, patch.global_node) - middle(graded_x_, graded_patch_));
  if (const double far = kFurthest * edge_; ahead.norm() > far) ahead *= far / ahead.norm();
  graded_patch_ = with_nodes_ahead(graded_x_, patch.global_node, ahead);
  fixed_.assign(n, 0);
  for (int i : tangent.fixed_nodes) fixed_[i] = 1;
  dofs_ = make_free_dofs(n, tangent.fixed_nodes);
  if (static_cast<int>(ranks_.size()) != n) {
    ranks_ = node_ranks(graded_x_);
    yielding_ = FarRows::Zero(dofs_.size(), kFarEach);
    vibrations_ = even_motions(dofs_, graded_x_);
  }
  interpolation_ = interpolate_far_nodes(graded_x_, ranks_, fixed_, graded_patch_, options_);
  has_coarse_ = leads_far_ = false;
  whole_ = 3 * num_kept() + kFar > 3 * dofs_.size() / 4;
  if (whole_) return;
  kept_row_.clear();
  followers_.clear();
  for (int i = 0; i < num_kept(); ++i) kept_row_.push_back(dofs_.to_free[3 * interpolation_.kept[i]] / 3);
  for (int i = 0, next = 0; i < dofs_.size() / 3; ++i)
    if (next < num_kept() && kept_row_[next] == i)
      ++next;
    else
      followers_.push_back(i);
  body_.dofs.to_free.assign(3 * static_cast<std::size_t>(n), -1);
  body_.dofs.to_all.clear();
  for (int i : interpolation_.kept)
    for (int c = 0; c < 3; ++c) {
      body_.dofs.to_free[3 * i + c] = body_.dofs.size();
      body_.dofs.to_all.push_back(3 * i + c);
    }
  confinement_ = BlockConfinement(blocks_, interpolation_);
  confinement_.product<9>(blocks_, blocks_.mass_values(), mass_sums_);
  make_matrix_pattern();
  if (gradings_ == 1)
    for (const auto& solver : {&coarse_, &solver_}) *solver = make_block_solver();
  std::vector<int> loaded;  // by the patch, and by all nodes: far motions
  for (int i : patch.global_node)
    if (const int k = body_.dofs.to_free[3 * i]; k >= 0) loaded.push_back(k / 3);
  for (int f = 0; f < kFar / 3; ++f) loaded.push_back(num_kept() + f);
  for (const auto& solver : {&coarse_, &solver_}) (*solver)->order_last(loaded);
}

/// Rows ascend in each column of the confinement: a column of the whole pattern is what earlier ones have to do with
/// it, then its own.
void GradedBody::make_matrix_pattern() {
  const int nodes = num_kept(), far = kFar / 3;
  std::vector<int> heights(static_cast<std::size_t>(nodes + far), far), above(static_cast<std::size_t>(nodes), 0);
  for (int b = 0; b < nodes; ++b)
    for (int k = confinement_.first(b) + 1; k < confinement_.last(b); ++k) ++above[confinement_.row(k)];
  for (int b = 0; b < nodes; ++b) heights[b] += above[b] + confinement_.last(b) - confinement_.first(b);
  for (int f = 0; f < far; ++f) heights[nodes + f] += nodes;
  std::vector<int> outer{0};
  for (int height : heights)
    for (int c = 0; c < 3; ++c) outer.push_back(outer.back() + 3 * height);

  std::vector<int> inner(static_cast<std::size_t>(outer.back()));
  const auto set = [&](int row, int column, int place) {  // the block that is the place-th of the column
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) inner[static_cast<std::size_t>(outer[3 * column + c] + 3 * place + r)] = 3 * row + r;
    return outer[3 * column] + 3 * place;
  };
  begins_.clear();
  std::vector<int> next(static_cast<std::size_t>(nodes), 0);
  for (int b = 0; b < nodes; ++b) {
    const int first = confinement_.first(b);
    for (int k = first; k < confinement_.last(b); ++k) {
      const int a = confinement_.row(k), begin = set(a, b, above[b] + k - first);
      begins_.push_back({begin, a == b ? begin : set(b, a, next[a]++)});
    }
  }
  for (int b = 0; b < nodes; ++b)
    for (int f = 0; f < far; ++f) {
      set(nodes + f, b, heights[b] - far + f);
      set(b, nodes + f, b);
    }
  for (int f = 0; f < far; ++f)
    for (int g = 0; g < far; ++g) set(nodes + f, nodes + g, nodes + f);
  const std::vector<double> zeros(inner.size(), 0.0);
  pattern_ =
      Eigen::Map<const SparseMatrix>(3 * (nodes + far), 3 * (nodes + far), static_cast<Eigen::Index>(inner.size()),
                                     outer.data(), inner.data(), zeros.data());
  body_.mass = body_.damping = body_.stiffness = pattern_;
}

/// Writes the blocks, nine numbers at the beginning of every `size`, and, from A far_apart, what couples to the far
/// motions.
void GradedBody::fill(SparseMatrix& out, const double* blocks, int size, const NodeRows<kFar>& times_far) const {
  double* values = out.valuePtr();
  const int* outer = out.outerIndexPtr();
  const int nodes = num_kept();
  for (int b = 0; b < nodes; ++b) {
    const int height = outer[3 * b + 1] - outer[3 * b];
    for (int k = confinement_.first(b); k < confinement_.last(b); ++k) {
      const double* block = blocks + static_cast<std::ptrdiff_t>(size) * k;
      const int a = confinement_.row(k), height_a = outer[3 * a + 1] - outer[3 * a];
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) {
          // The products of both triangles differ by rounding on the diagonal only.
          const double value = a == b ? 0.5 * (block[3 * c + r] + block[3 * r + c]) : block[3 * c + r];
          values[begins_[k][0] + c * height + r] = value;
          if (a != b) values[begins_[k][1] + r * height_a + c] = value;
        }
    }
  }
  const NodeRows<kFar> border = restrict_forces<kFar>(times_far) * far_basis_;

  const FarBlock corner = far_basis_.transpose() * symmetric_product(far_apart_, times_far) * far_basis_;
  for (int c = 0; c < 3 * nodes; ++c)
    for (int f = 0; f < kFar; ++f) {
      values[outer[c + 1] - kFar + f] = border(c, f);
      values[outer[3 * nodes + f] + c] = border(c, f);
    }
  for (int f = 0; f < kFar; ++f)
    for (int g = 0; g < kFar; ++g) {
      // A motion that was dropped stands apart, as a mass on a spring that nothing moves.
      const double dropped = f == g && far_basis_.col(f).isZero(0) ? 1 : 0;
      values[outer[3 * nodes + f] + 3 * nodes + g] = 0.5 * (corner(f, g) + corner(g, f)) + dropped;
    }
}

/// The stiffness of the kept nodes alone, once for a choice of nodes: it need not be the present one.
void GradedBody::factor_preconditioner() {
  far_basis_.setZero();
  far_apart_ = NodeRows<kFar>::Zero(dofs_.size(), kFar);
  fill(body_.stiffness, sums_.data(), 18, far_apart_);
  added_mass_ = 0;
  has_coarse_ = coarse_->factor(body_.stiffness);
  solver_->take_analysis(*coarse_);
  if (has_coarse_) return;
  fill(body_.mass, mass_sums_.data(), 9, far_apart_);
  added_mass_ = square(2 * std::numbers::pi);
  body_.stiffness += added_mass_ * body_.mass;
  has_coarse_ = coarse_->factor(body_.stiffness);
}

/// The kept nodes' response, and each follower's to the force on it alone. The kept nodes' is that of the last refresh,
/// with the far motions, where it is at hand.
FarRows GradedBody::precondition(const FarRows& residual) const {
  FarRows out;
  if (leads_far_) {
    out = expand<kFarEach>(solver_->solve(contract<kFarEach>(residual)));
  } else {
    MatrixX coarse = MatrixX::Zero(pattern_.rows(), kFarEach);
    coarse.topRows(3 * num_kept()) = restrict_forces<kFarEach>(residual);
    out = prolong<kFarEach>(coarse_->solve(coarse).topRows(3 * num_kept()));
  }
  for (std::size_t k = 0; k < followers_.size(); ++k)
    out.middleRows<3>(3 * followers_[k]) += node_inverse_[k] * residual.middleRows<3>(3 * followers_[k]);
  return out;
}

/// Of the diagonal blocks of K + w D + w^2 M.
std::vector<Mat3> GradedBody::follower_inverses(double w) const {
  std::vector<Mat3> out(followers_.size());
  for (std::size_t k = 0; k < followers_.size(); ++k) {
    const auto at = static_cast<std::ptrdiff_t>(blocks_.diagonal(followers_[k]));
    const double* pair = blocks_.values().data() + NodeBlocks::kSize * at;
    const Mat3 block = Eigen::Map<const Mat3>(pair) + w * Eigen::Map<const Mat3>(pair + 9) +
                       w * w * Eigen::Map<const Mat3>(blocks_.mass_values().data() + 9 * at);
    out[k] = block.determinant() > 0 ? Mat3(block.inverse()) : Mat3(Mat3::Zero());
  }
  return out;
}

GradedBody::Preconditioner::Preconditioner(const GradedBody& body, double w)
    : body_(body), node_inverse_(body.follower_inverses(w)) {
  if (body.is_factored_) return;
  if (!body.solver_->factor(dynamic_stiffness(body.body_, w)))
    throw IndefiniteTangent(text("certificate: the body is not positive definite at ", w, " 1/s"));
}

NodeRows<6> GradedBody::Preconditioner::apply(const NodeRows<6>& forces) const {
  NodeRows<6> out = body_.expand<6>(body_.solver_->solve(body_.contract<6>(forces)));
  for (std::size_t k = 0; k < node_inverse_.size(); ++k)
    out.middleRows<3>(3 * body_.followers_[k]) += node_inverse_[k] * forces.middleRows<3>(3 * body_.followers_[k]);
  return out;
}

/// @param turns  one turn improves one kind of motions, the next the other
void GradedBody::improve_far_motions(const TangentModel& tangent, const SurfacePatch& patch, int turns, int steps) {
  if (!leads_far_ && !has_coarse_) return;
  node_inverse_ = follower_inverses(0);
  const FarOperators body{[&](const FarRows& u, FarRows& out) {
                            blocks_.stiffness<kFarEach>(u, out);
                            if (added_mass_ == 0) return;
                            FarRows inertia;
                            blocks_.mass<kFarEach>(u, inertia);
                            out += added_mass_ * inertia;
                          },
                          [&](const FarRows& u, FarRows& out) { blocks_.mass<kFarEach>(u, out); },
                          [&](const FarRows& forces) { return precondition(forces); }};
  for (int turn = 0; turn < turns; ++turn)
    if (++turns_ % 2 == 1) {
      if (!improve_yielding(yielding_, smooth_loads(dofs_, tangent.state.x, patch), body, steps)) yielding_.setZero();
    } else if (!improve_vibrations(vibrations_, body, steps)) {
      vibrations_ = even_motions(dofs_, tangent.state.x);
    }
}

/// Takes out what the kept nodes can do themselves, so that these alone say how they move.
void GradedBody::set_far_apart() {
  far_apart_.resize(dofs_.size(), kFar);
  far_apart_ << yielding_, vibrations_;
  NodeRows<kFar> kept(3 * num_kept(), kFar);
  for (int i = 0; i < num_kept(); ++i) kept.middleRows<3>(3 * i) = far_apart_.middleRows<3>(3 * kept_row_[i]);
  far_apart_ -= prolong<kFar>(kept);
  for (int row : kept_row_) far_apart_.middleRows<3>(3 * row).setZero();
}

void GradedBody::fill_matrices() {
  NodeRows<kFar> product, damped;
  blocks_.mass<kFar>(far_apart_, product);
  far_basis_ = orthonormalizer<kFar>(symmetric_product(far_apart_, product));
  fill(body_.mass, mass_sums_.data(), 9, product);
  blocks_.stiffness_and_damping<kFar>(far_apart_, product, damped);
  fill(body_.stiffness, sums_.data(), 18, product);
  fill(body_.damping, sums_.data() + 9, 18, damped);
}

const FreeBody& GradedBody::update_whole(const TangentModel& tangent) {
  whole_ = true;
  is_graded_anew_ = false;
  is_factored_ = false;
  followers_.clear();
  dofs_ = make_free_dofs(static_cast<int>(tangent.f0.size()) / 3, tangent.fixed_nodes);
  blocks_.update(tangent, dofs_);
  body_ = FreeBody(tangent);
  return body_;
}

const FreeBody& GradedBody::update(const TangentModel& tangent, const SurfacePatch& patch) {
  const Stage stage("grading");
  const bool is_first = turns_ == 0, covered = covers(tangent, patch);
  is_factored_ = false;
  if (covered && whole_) return update_whole(tangent);
  const FreeDofs dofs = covered ? dofs_ : make_free_dofs(static_cast<int>(tangent.f0.size()) / 3, tangent.fixed_nodes);
  // Of one pattern, unless contacts of the body with itself came or went.
  const bool stays = !blocks_.update(tangent, dofs) && covered;
  // Far motions are the whole body's: the kept nodes of before lead them as well, and a factor of these is at hand.
  const bool is_led = leads_far_ = leads_far_ && !whole_ && dofs.to_all == dofs_.to_all;
  const auto improve = [&] {
    const Stage improving("grading: far motions");
    const int turns = stays ? 1 : is_first ? kSetUpTurns : kTurnsAnew;
    improve_far_motions(tangent, patch, turns, is_first ? kSetUpSteps : kSteps);
  };
  if (stays) rests_ = !rests_;
  const bool improves_now = is_led && !(stays && rests_);
  if (improves_now) improve();
  if (!stays) {
    choose_nodes(tangent, patch);
    if (whole_) return update_whole(tangent);
  }
  confinement_.product<18>(blocks_, blocks_.values(), sums_);
  leads_far_ = false;
  if (!is_led) {
    if (!has_coarse_) factor_preconditioner();
    improve();
  }
  is_graded_anew_ = !stays;
  set_far_apart();
  fill_matrices();

  NodeRows<1> force = gather(dofs_, VectorX(tangent.f0 - tangent.dfdv * tangent.state.v));
  body_.force = contract<1>(force);
  body_.x = tangent.state.x;
  body_.velocity = VectorX::Zero(body_.force.size());
  for (int k = 0; k < 3 * num_kept(); ++k) body_.velocity[k] = tangent.state.v[body_.dofs.to_all[k]];
  return body_;
}

}  // namespace kt
