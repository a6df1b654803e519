#include "view/playback.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "haptics/touch/touch.hpp"
#include "haptics/touch/touch_halves.hpp"

namespace kt {
namespace {

constexpr double kPerSecond = 30;                 // pictures
constexpr double kMostBytes = 512.0 * (1 << 20);  // of all pictures: a long session of a large body has fewer a second

}  // namespace

Playback::Playback(const Scene& scene, SceneFiles files, SessionOptions replay)
    : session_(scene, std::move(files)),
      shape_(make_body_shape(session_.surface(), session_.model().mesh().num_nodes(), still_nodes(session_.model()))) {
  const double rate = scene.local.rate_hz, each = 6.0 * static_cast<double>(shape_.nodes.size()) + 1000;
  every_ = static_cast<int>(
      std::max({1.0, std::round(rate / kPerSecond), std::ceil(scene.duration * rate * each / kMostBytes)}));
  replay.watcher = this;
  replay.check_contacts = false;
  result_ = session_.run(replay);
  if (result_.stopped || pictures_.empty()) throw RunError("the session's replay was stopped");
}

void Playback::ticked(std::span<const LocalFrame> frames, double /*step_us*/, long long /*allocations*/) {
  ticks_.push_back({static_cast<float>(frames[0].f_n), static_cast<float>(frames[0].f_t), frames[0].mode});
  if ((static_cast<int>(ticks_.size()) - 1) % every_ != 0) return;
  RefreshPicture refresh;
  touch_->copy_refresh(refresh);
  if (refreshes_.empty() || refreshes_.back().refreshes != refresh.refreshes) refreshes_.push_back(std::move(refresh));
  LiveRun::Picture& out = pictures_.emplace_back();
  out.t = frames[0].t;
  out.refreshes = refreshes_.back().refreshes;
  out.target = frames[0].pose.x;
  out.tools.assign(frames.begin(), frames.end());
  VectorX x;
  TouchHalves::copy_positions_now(*touch_, x);
  out.positions = pack_positions(x, shape_.nodes);
}

const LiveRun::Picture& Playback::at(double t) const {
  const auto after = std::ranges::upper_bound(pictures_, t + 1e-9, {}, &LiveRun::Picture::t);
  return after == pictures_.begin() ? pictures_.front() : *std::prev(after);
}

const RefreshPicture& Playback::refresh_at(double t) const {
  const int refreshes = at(t).refreshes;
  return *std::ranges::lower_bound(refreshes_, refreshes, {}, &RefreshPicture::refreshes);
}

}  // namespace kt
