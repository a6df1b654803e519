#include "haptics/force_blend.hpp"

namespace kt {

ForceBlend::ForceBlend(double h, double duration) noexcept : per_tick_(std::min(1.0, h / duration)) {}

Vec3 ForceBlend::apply(const Vec3& force, bool touches, bool lost, const Vec3& moved) noexcept {
  const bool starts_fading_out = lost && touched_ && !fading_out_;
  const bool comes_back = touches && fading_out_;
  if ((begins_ && touches && touched_) || starts_fading_out || comes_back) {
    difference_ = last_ - force;
    left_ = 1;
  }
  if (!touches && !lost) left_ = 0;
  begins_ = false;
  fading_out_ = lost;
  touched_ = touches || lost;

  left_ = std::max(0.0, left_ - per_tick_);
  Vec3 out = force + left_ * difference_;
  // Only what the hand has put in may come back; the model's own force answers for itself.
  if (const double given = left_ * difference_.dot(moved); given > 0 && work_ - out.dot(moved) < 0) {
    difference_ -= difference_.dot(moved) / moved.squaredNorm() * moved;
    out = force + left_ * difference_;
  }
  work_ -= out.dot(moved);
  last_ = out;
  return out;
}

}  // namespace kt
