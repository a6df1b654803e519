#pragma once
// The bound of a tick's work. A clock would bound it as well, but a replay would not have the same bits.

namespace kt {

/// Multiply-adds of the loops that grow with the number of contacts: sweeps, direct solutions, corrections of gaps.
class ContactWork {
 public:
  explicit ContactWork(long most = 0) noexcept : left_(most) {}
  void take(long count) noexcept { left_ -= count; }
  void take_factor(long unknowns) noexcept { take(unknowns * unknowns * unknowns / 3); }
  bool is_over() const noexcept { return left_ <= 0; }
  long left() const noexcept { return left_; }

 private:
  long left_;
};

}  // namespace kt
