#include "haptics/contact/contact_sweeps.hpp"

#include <algorithm>
#include <limits>

namespace kt {
namespace {

constexpr double kLook = 10;      // times the residual that is asked for: a sweep leaves less than it changed
constexpr double kWorse = 4;      // squared change against the last sweep's: below it, extrapolation only wavers
constexpr int kSlipsToLetGo = 3;  // static friction that gave way so often in one solve is overcome

// Wider vectors where the machine has them: the same sums, so the same digits.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define KT_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define KT_WIDE
#endif

KT_WIDE void add_many(double* __restrict v, const double* __restrict a, Eigen::Index stride, double s0, double s1,
                      double s2, Eigen::Index n) noexcept {
  const double* __restrict a1 = a + stride, * __restrict a2 = a1 + stride;
  for (Eigen::Index i = 0; i < n; ++i) v[i] += a[i] * s0 + a1[i] * s1 + a2[i] * s2;
}

/// v += A s for three columns of A. Column by column rather than row by row: each entry is its own sum, so that the
/// result is the same whatever the width of the machine's vectors.
inline void add_columns(double* v, const double* a, Eigen::Index stride, const Vec3& s, Eigen::Index n) noexcept {
  constexpr Eigen::Index kFew = 12;  // they take less than the call
  if (n > kFew) return add_many(v, a, stride, s[0], s[1], s[2], n);
  for (Eigen::Index i = 0; i < n; ++i) v[i] += a[i] * s[0] + a[stride + i] * s[1] + a[2 * stride + i] * s[2];
}

}  // namespace

ContactSweeps::ContactSweeps(int capacity)
    : contact_(static_cast<std::size_t>(capacity)),
      mu_(contact_.size()),
      slips_(contact_.size()),
      lambda_(contact_.size()),
      direct_(3 * capacity),
      trial_{VectorX(3 * capacity), std::vector<ContactMode>(contact_.size()), mu_, slips_},
      best_(trial_),
      velocity_(3 * capacity),
      step_(3 * capacity),
      last_step_(3 * capacity),
      last_impulse_(3 * capacity),
      last_velocity_(3 * capacity),
      steps_(3 * capacity, kDepth),
      impulses_(3 * capacity, kDepth),
      velocities_(3 * capacity, kDepth) {}

void ContactSweeps::find_velocity(const ContactSystem& system, const Eigen::Ref<const VectorX>& impulse) noexcept {
  const Eigen::Index n = system.velocity.size(), stride = system.W.outerStride();
  velocity_.head(n) = system.velocity;
  for (Eigen::Index i = 0; i < n; i += 3)
    if (const Vec3 p = impulse.segment<3>(i); !p.isZero(0))
      add_columns(velocity_.data(), system.W.data() + i * stride, stride, p, n);
}

/// One pass over the contacts. Returns the largest change, relative like the residual.
double ContactSweeps::sweep(const ContactSystem& system, Eigen::Ref<VectorX> impulse,
                            std::span<ContactMode> mode) noexcept {
  const int c = static_cast<int>(system.normal.size());
  const Eigen::Index stride = system.W.outerStride();
  double change = 0, largest = 0;
  for (int i = 0; i < c; ++i) {
    const Vec3 old = impulse.segment<3>(3 * i);
    const double* column = system.W.data() + 3 * i * stride;
    Vec3 free = velocity_.segment<3>(3 * i);
    if (!old.isZero(0)) free -= system.W.block<3, 3>(3 * i, 3 * i) * old;
    const bool slid = !system.sliding.empty() && system.sliding[i];
    const bool sliding = slid || slips_[i] >= kSlipsToLetGo;
    if (lambda_[i] < 0) lambda_[i] = contact_[i].slip_ratio(free, old);
    const OneContactSolution one = contact_[i].solve(free, system.friction[i], sliding, lambda_[i]);
    if (mode[i] == ContactMode::stick && one.mode == ContactMode::frictional_slide) ++slips_[i];
    mode[i] = one.mode;
    mu_[i] = one.mu;
    if (one.lambda > 0) lambda_[i] = one.lambda;
    const Vec3 step = one.impulse - old;
    step_.segment<3>(3 * i) = step;
    largest = std::max(largest, one.impulse.squaredNorm());
    if (step.isZero(0)) continue;
    impulse.segment<3>(3 * i) = one.impulse;
    add_columns(velocity_.data(), column, stride, step, 3 * c);
    change = std::max(change, step.squaredNorm());
  }
  return largest > 0 ? std::sqrt(change / largest) : 0.0;
}

/// Files what the last sweep did as a difference to the sweep before.
void ContactSweeps::remember(const Eigen::Ref<const VectorX>& impulse, int n) noexcept {
  if (has_last_) {
    auto column = steps_.col(next_).head(n);
    column = step_.head(n) - last_step_.head(n);
    impulses_.col(next_).head(n) = impulse - last_impulse_.head(n);
    velocities_.col(next_).head(n) = velocity_.head(n) - last_velocity_.head(n);
    remembered_ = std::min(remembered_ + 1, kDepth);
    for (int k = 0; k < remembered_; ++k) {
      const double product = steps_.col(k).head(n).dot(column);
      gram_(k, next_) = gram_(next_, k) = product;
      along_[k] += product;
    }
    along_[next_] = column.dot(step_.head(n));
    next_ = (next_ + 1) % kDepth;
  }
  last_step_.head(n) = step_.head(n);
  last_impulse_.head(n) = impulse;
  last_velocity_.head(n) = velocity_.head(n);
  has_last_ = true;
}

/// The combination of the remembered sweeps whose changes cancel best. Velocities are affine in the impulses, so they
/// are combined alike, without W.
void ContactSweeps::extrapolate(Eigen::Ref<VectorX> impulse, int n) noexcept {
  const int m = remembered_;
  if (m == 0) return;
  // Cholesky's factor of the Gram matrix, in which a column that depends on others is left out.
  double lower[kDepth][kDepth], right[kDepth];
  for (int k = 0; k < m; ++k) {
    double rhs = along_[k];
    for (int j = 0; j < k; ++j) {
      double sum = gram_(k, j);
      for (int l = 0; l < j; ++l) sum -= lower[k][l] * lower[j][l];
      lower[k][j] = lower[j][j] > 0 ? sum / lower[j][j] : 0.0;
      rhs -= lower[k][j] * right[j];
    }
    double own = gram_(k, k);
    for (int l = 0; l < k; ++l) own -= lower[k][l] * lower[k][l];
    lower[k][k] = own > 1e-10 * gram_(k, k) ? std::sqrt(own) : 0.0;
    right[k] = lower[k][k] > 0 ? rhs / lower[k][k] : 0.0;
  }
  for (int k = m - 1; k >= 0; --k) {
    for (int l = k + 1; l < m; ++l) right[k] -= lower[l][k] * right[l];
    right[k] = lower[k][k] > 0 ? right[k] / lower[k][k] : 0.0;
  }
  for (int k = 0; k < m; ++k) {
    if (right[k] == 0) continue;
    impulse -= right[k] * impulses_.col(k).head(n);
    velocity_.head(n) -= right[k] * velocities_.col(k).head(n);
  }
}

void ContactSweeps::forget() noexcept {
  remembered_ = next_ = 0;
  has_last_ = false;
}

/// With the present velocities.
double ContactSweeps::residual_of(const ContactSystem& system, const Eigen::Ref<const VectorX>& impulse) noexcept {
  const auto count = static_cast<std::size_t>(system.count());
  return natural_residual(system, impulse, velocity_.head(impulse.size()), {mu_.data(), count});
}

/// A sweep from there; taken if it leaves less than the present one.
bool ContactSweeps::try_from(const ContactSystem& system, const Eigen::Ref<const VectorX>& start,
                             Eigen::Ref<VectorX> impulse, std::span<ContactMode> mode, SweepResult& out) noexcept {
  ++out.sweeps;
  work_.take(2 * system.W.size());
  Trial& t = trial_;
  const Eigen::Index n = start.size();
  t.impulse.head(n) = start;
  std::ranges::copy(mode, t.mode.begin());
  t.mu = mu_;
  t.slips = slips_;
  find_velocity(system, start);
  sweep(system, t.impulse.head(n), {t.mode.data(), mode.size()});
  const double residual = residual_of(system, t.impulse.head(n));  // of a sweep right after its velocities
  if (!(residual < out.residual)) {
    mu_.swap(t.mu);
    slips_.swap(t.slips);
    return false;
  }
  impulse = t.impulse.head(n);
  std::ranges::copy_n(t.mode.begin(), static_cast<std::ptrdiff_t>(mode.size()), mode.begin());
  out.residual = residual;
  return true;
}

/// Leaves the best that it finds.
void ContactSweeps::solve_directly(const ContactSystem& system, const SweepLimits& limits, Eigen::Ref<VectorX> impulse,
                                   std::span<ContactMode> mode, SweepResult& out) noexcept {
  constexpr int kSteps = 6;
  const int c = system.count();
  std::array<double, ContactNewton::kMost> mu;
  for (int i = 0; i < c; ++i) mu[i] = mode[i] == ContactMode::free ? system.friction[i].mu_at(0) : mu_[i];
  auto direct = direct_.head(3 * c);
  direct = impulse;
  if (newton_.pivot(system, limits.pivots, mu, mode, direct, work_)) try_from(system, direct, impulse, mode, out);
  for (int step = 0; step < kSteps && out.residual > limits.residual && !work_.is_over(); ++step) {
    if (!newton_.step(system, mu, direct, work_)) break;
    try_from(system, direct, impulse, mode, out);
  }
  find_velocity(system, impulse);
  forget();
}

/// A contact alone needs no sweeps.
SweepResult ContactSweeps::solve_one(const ContactSystem& system, Eigen::Ref<VectorX> impulse,
                                     ContactMode& mode) noexcept {
  const OneContact contact(system.W.topLeftCorner<3, 3>(), system.normal[0]);
  const Vec3 velocity = system.velocity.head<3>();
  const bool sliding = !system.sliding.empty() && system.sliding[0];
  const OneContactSolution one =
      contact.solve(velocity, system.friction[0], sliding, contact.slip_ratio(velocity, impulse.head<3>()));
  mode = one.mode;
  impulse.head<3>() = one.impulse;
  const Vec3 after = velocity + system.W.topLeftCorner<3, 3>() * one.impulse;
  return {1, natural_residual(system, impulse, after, {&one.mu, 1})};
}

SweepResult ContactSweeps::solve(const ContactSystem& system, const SweepLimits& limits, Eigen::Ref<VectorX> impulse,
                                 std::span<ContactMode> mode) noexcept {
  const int c = system.count();
  if (c == 1) return solve_one(system, impulse, mode[0]);
  work_ = limits.work ? *limits.work : ContactWork(std::numeric_limits<long>::max());
  const SweepResult out = solve_many(system, limits, impulse, mode);
  if (limits.work) *limits.work = work_;
  return out;
}

SweepResult ContactSweeps::solve_many(const ContactSystem& system, const SweepLimits& limits,
                                      Eigen::Ref<VectorX> impulse, std::span<ContactMode> mode) noexcept {
  constexpr int kDirectlyAfter = 24;  // sweeps, each time
  const int c = system.count(), n = 3 * c;
  SweepResult out;
  for (int i = 0; i < c; ++i) {
    contact_[i] = OneContact(system.W.block<3, 3>(3 * i, 3 * i), system.normal[i]);
    slips_[i] = 0;
    lambda_[i] = -1;
    mode[i] = ContactMode::free;
  }
  find_velocity(system, impulse);
  forget();
  int rounds = 0, since = 0;
  double last_change = 0, best = std::numeric_limits<double>::infinity();
  for (;;) {
    ++out.sweeps;
    const double change = sweep(system, impulse, mode);
    work_.take(system.W.size());
    const bool is_last = out.sweeps >= limits.sweeps || work_.is_over();
    const bool is_slow = ++since == kDirectlyAfter && c <= ContactNewton::kMost && rounds < limits.direct_rounds;
    if (change <= kLook * limits.residual || is_last || is_slow) {
      if (out.sweeps > 1) find_velocity(system, impulse);  // extrapolations leave it behind by their rounding
      out.residual = residual_of(system, impulse);
      if (is_last && best < out.residual) {  // sweeps after it only wavered
        impulse = best_.impulse.head(n);
        std::ranges::copy_n(best_.mode.begin(), c, mode.begin());
        out.residual = best;
      }
      if (out.residual <= limits.residual || is_last) return out;
    }
    if (is_slow) {
      solve_directly(system, limits, impulse, mode, out);
      if (out.residual <= limits.residual) return out;
      best_.impulse.head(n) = impulse;
      std::ranges::copy(mode, best_.mode.begin());
      best = out.residual;
      ++rounds;
      since = 0;
      continue;
    }
    const double now = step_.head(n).squaredNorm();
    // Another piece of the law: what is remembered belongs to the last one.
    if (has_last_ && now > kWorse * last_change) forget();
    last_change = now;
    remember(impulse, n);
    extrapolate(impulse, n);
  }
}

}  // namespace kt
