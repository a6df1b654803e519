#pragma once
// Several contacts with exact Coulomb friction: block Gauss-Seidel over exact one-contact solves (Jourdan, Alart and
// Jean 1998), accelerated by Anderson's extrapolation (Walker and Ni 2011), and where they do not get on by direct
// solutions. Any number of contacts; no allocation.
#include <span>
#include <vector>

#include "haptics/contact/contact_newton.hpp"
#include "haptics/contact/contact_work.hpp"

namespace kt {

struct SweepLimits {
  int sweeps = 100;
  int direct_rounds = 3;        ///< times that impulses are looked for directly, where sweeps get on slowly
  int pivots = 120;             ///< changes of mode in each of them: each solves a linear system of all contacts
  double residual = 1e-6;       ///< converged: see natural_residual
  ContactWork* work = nullptr;  ///< no further sweep once it is over; null: no bound
};

struct SweepResult {
  int sweeps = 0;
  double residual = 0;
};

/// Room for up to `capacity` contacts, made once; belongs to one thread.
class ContactSweeps {
 public:
  explicit ContactSweeps(int capacity);

  /// @param impulse  in: to start from; out: the result, inside the cones and without pull, converged or not, (3c)
  /// With more rows than the body has freedoms W is singular: velocities are still unique where they are without
  /// friction, impulses are not, and the ones found are near those that it started from.
  SweepResult solve(const ContactSystem& system, const SweepLimits& limits, Eigen::Ref<VectorX> impulse,
                    std::span<ContactMode> mode) noexcept;

 private:
  static constexpr int kDepth = 4;  // differences that the extrapolation remembers
  SweepResult solve_many(const ContactSystem& system, const SweepLimits& limits, Eigen::Ref<VectorX> impulse,
                         std::span<ContactMode> mode) noexcept;
  SweepResult solve_one(const ContactSystem& system, Eigen::Ref<VectorX> impulse, ContactMode& mode) noexcept;
  void find_velocity(const ContactSystem& system, const Eigen::Ref<const VectorX>& impulse) noexcept;
  double sweep(const ContactSystem& system, Eigen::Ref<VectorX> impulse, std::span<ContactMode> mode) noexcept;
  void extrapolate(Eigen::Ref<VectorX> impulse, int n) noexcept;
  void forget() noexcept;
  double residual_of(const ContactSystem& system, const Eigen::Ref<const VectorX>& impulse) noexcept;
  bool try_from(const ContactSystem& system, const Eigen::Ref<const VectorX>& start, Eigen::Ref<VectorX> impulse,
                std::span<ContactMode> mode, SweepResult& out) noexcept;
  void solve_directly(const ContactSystem& system, const SweepLimits& limits, Eigen::Ref<VectorX> impulse,
                      std::span<ContactMode> mode, SweepResult& out) noexcept;
  void remember(const Eigen::Ref<const VectorX>& impulse, int n) noexcept;

  std::vector<OneContact> contact_;
  std::vector<double> mu_;
  std::vector<int> slips_;      // times that a contact went from sticking to slipping in this solve
  std::vector<double> lambda_;  // of each contact's last slip; -1: not known yet
  struct Trial {
    VectorX impulse;
    std::vector<ContactMode> mode;
    std::vector<double> mu;
    std::vector<int> slips;
  };
  ContactNewton newton_;
  VectorX direct_;      // its present answer
  Trial trial_, best_;  // a sweep from there; what the last direct solution left
  VectorX velocity_;    // with the present impulses
  VectorX step_;        // what the last sweep changed
  VectorX last_step_, last_impulse_, last_velocity_;
  MatrixX steps_, impulses_, velocities_;  // differences between successive sweeps, (3c x kDepth), a ring
  Eigen::Matrix<double, kDepth, kDepth> gram_;
  std::array<double, kDepth> along_{};  // products of steps_ with the last sweep's step
  int remembered_ = 0, next_ = 0;
  bool has_last_ = false;
  ContactWork work_;  // of the present solve
};

}  // namespace kt
