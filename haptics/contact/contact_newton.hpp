#pragma once
// For a few contacts that are nearly one, as several facets under a round tool: sweeps hardly get on there, since what
// one gives another takes. Direct solutions of all of them, from which sweeps go on. No allocation.
#include "haptics/contact/contact_system.hpp"
#include "haptics/contact/contact_work.hpp"
#include "haptics/contact/one_contact.hpp"

namespace kt {

class ContactNewton {
 public:
  static constexpr int kMost = 16;  ///< contacts

  /// Which of them push: all that do are solved at once, one that would pull is let go, one that is overlapped comes
  /// back, until none is left of either (principal pivoting: Murty 1974). Sticking contacts stick or, where that leaves
  /// the cone, slide; sliding ones keep the direction of their impulse. Without friction this is the solution.
  /// @param mu       per contact, of its cone
  /// @param impulse  in: a sweep's result; out: the answer, unchanged where there is none, (3c)
  /// @param work     what it takes is taken off; once it is over there is no answer
  bool pivot(const ContactSystem& system, int most_changes, std::span<const double> mu,
             std::span<const ContactMode> mode, Eigen::Ref<VectorX> impulse, ContactWork& work) noexcept;

  /// One step of Newton's method on u_m = 0, and u_t = 0 or p_t = mu p_m y / |y| with y = p_t - r u_t, of the contacts
  /// with p_m > r u_m; p = 0 of the others. False: no step. Alart and Curnier 1991.
  bool step(const ContactSystem& system, std::span<const double> mu, Eigen::Ref<VectorX> impulse,
            ContactWork& work) noexcept;

 private:
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3 * kMost, 3 * kMost>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3 * kMost, 1>;
  bool solve(const ContactSystem& system, std::span<const ContactMode> mode, std::span<const Vec3> direction,
             Vector& out) noexcept;

  Matrix matrix_;
  Vector right_;
};

}  // namespace kt
