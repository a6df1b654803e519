#include "haptics/tick/force_blend.hpp"

namespace kt {

namespace {

/// Ticks in which a new local model that was not run in finds its balance: the parts of the body that it follows and
/// the one before did not start from rest. Its force in the first one can be a quarter off and says little about the
/// difference of the two.
constexpr int kSettling = 4;

}  // namespace

ForceBlend::ForceBlend(double h, double duration) noexcept : per_tick_(std::min(1.0, h / duration)) {}

Vec3 ForceBlend::apply(const Vec3& force, bool touches, bool lost, const Vec3& moved, double others) noexcept {
  const bool starts_fading_out = lost && touched_ && !fading_out_;
  const bool comes_back = touches && fading_out_;
  const bool begins = begins_ && touches && touched_;
  if (begins) settling_ = before_ ? 0 : kSettling;
  if (begins && before_) {
    difference_ = last_ - *before_;
    left_ = 1;
  } else if (begins || starts_fading_out || comes_back || (settling_ > 0 && touches)) {
    difference_ = last_ - force;
    left_ = 1;
  }
  settling_ = touches ? std::max(0, settling_ - 1) : 0;
  if (!touches && !lost) left_ = 0;
  begins_ = false;
  fading_out_ = lost;
  touched_ = touches || lost;

  left_ = std::max(0.0, left_ - per_tick_ / longer_);
  Vec3 out = force + left_ * difference_;
  // Only what hands have put in may come back; the model's own force answers for itself.
  if (const double given = left_ * difference_.dot(moved); given > 0 && work_ + others - out.dot(moved) < 0) {
    difference_ -= difference_.dot(moved) / moved.squaredNorm() * moved;
    out = force + left_ * difference_;
  }
  work_ -= out.dot(moved);
  last_ = out;
  return out;
}

}  // namespace kt
