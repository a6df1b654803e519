#include "network/model_worker.hpp"

#include <limits>

#include "haptics/refresh/touch_parts.hpp"

namespace kt {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kMostWaiting = 8;  // local models whose ticks are not looked at yet

}  // namespace

ModelWorker::ModelWorker(const Body& body, const TouchOptions& options, const SurfaceFriction& friction,
                         ModelObserver* observer, TickEnd& ticks, const SharedHistory& history)
    : unpacker_(body, options),
      tools_(options.tools.size()),
      observer_(observer),
      ticks_(ticks),
      history_(history),
      catch_up_(shapes_of(options), tick_length(options), catch_up_solver(options, friction)) {}

std::unique_ptr<PreparedLocalModel> ModelWorker::first(const ModelMessage& message) {
  const std::string wrong = unpacker_.trouble(message.model);
  if (!wrong.empty()) throw RunError("the server's first local model: " + wrong);
  show(message);
  ++arrived_;
  auto model = unpacker_.unpack(message.model);
  yields_.add(*model);
  return model;
}

void ModelWorker::start() {
  thread_ = std::thread([this] { run(); });
}

void ModelWorker::stop() {
  if (!thread_.joinable()) return;
  {
    const std::scoped_lock lock(guard_);
    stop_ = true;
  }
  came_.notify_one();
  thread_.join();
  while (look_back(std::numeric_limits<int>::max())) {
  }
}

void ModelWorker::put(Bytes bytes, int tick0) {
  const int now = history_.end();
  const std::scoped_lock lock(guard_);
  bytes_ = std::move(bytes);
  tick0_ = tick0;
  came_at_ = now;
  came_.notify_one();
}

std::optional<ModelWorker::Way> ModelWorker::take_way(int frame) {
  const std::scoped_lock lock(guard_);
  const auto found = ways_.find(frame);
  if (found == ways_.end()) return {};
  const Way out = found->second;
  ways_.erase(ways_.begin(), std::next(found));
  return out;
}

void ModelWorker::note(const LocalMotion& motion) {
  const std::scoped_lock lock(guard_);
  yields_.note(motion);
}

void ModelWorker::forget() {
  const std::scoped_lock lock(guard_);
  yields_.clear();
}

void ModelWorker::look_back_on(std::unique_ptr<PreparedLocalModel> model) {
  if (!model) return;
  const std::scoped_lock lock(guard_);
  swaps_.add(*model);
  if (observer_) past_.push_back(std::move(model));
}

TouchStatus ModelWorker::status() const {
  const std::scoped_lock lock(guard_);
  TouchStatus out = status_;
  out.energy = swaps_.booked();
  return out;
}

void ModelWorker::copy_positions(VectorX& x) const {
  const std::scoped_lock lock(guard_);
  x = x_;
}

void ModelWorker::set_late(int ticks) {
  const std::scoped_lock lock(guard_);
  status_.late_ticks = ticks;
}

void ModelWorker::fail(const std::string& why) {
  const std::scoped_lock lock(guard_);
  status_.error = why;
}

void ModelWorker::add_to(HandLinkReport& report) const {
  const std::scoped_lock lock(guard_);
  report.models_arrived = arrived_;
  report.models_wrong = wrong_;
  report.last_trouble = trouble_;
}

std::optional<double> ModelWorker::loss() const {
  const std::scoped_lock lock(guard_);
  return loss_;
}

void ModelWorker::run() {
  for (;;) {
    Bytes bytes;
    int tick0 = 0, came_at = 0;
    {
      std::unique_lock lock(guard_);
      came_.wait_for(lock, past_.empty() ? 20ms : 1ms, [&] { return stop_ || !bytes_.empty(); });
      if (stop_) return;
      bytes = std::exchange(bytes_, {});
      tick0 = tick0_;
      came_at = came_at_;
    }
    if (bytes.empty())
      look_back(16);
    else
      try {
        unpack(bytes, tick0, came_at);
      } catch (const std::exception& e) {
        refuse(e.what());
      }
  }
}

void ModelWorker::refuse(const std::string& why) {
  const std::scoped_lock lock(guard_);
  ++wrong_;
  trouble_ = why;
}

void ModelWorker::unpack(const Bytes& bytes, int tick0, int came_at) {
  auto message = decode_model(bytes);
  if (!message) return refuse("it is none");
  if (const std::string wrong = unpacker_.trouble(message->model); !wrong.empty()) return refuse(wrong);
  auto parcel = std::make_unique<ModelParcel>();
  parcel->model = unpacker_.unpack(message->model);
  parcel->frame = message->model.frame;
  parcel->linearized_tick = parcel->at_tick = parcel->model->linearized_tick += tick0;
  {
    const std::scoped_lock lock(guard_);
    yields_.add(*parcel->model);
    yields_.start(*parcel->model, parcel->linearized_tick);
  }
  for (int round = 0; round < 8; ++round) {
    const std::vector<ToolSweep> sweeps = history_.from(parcel->at_tick);
    if (sweeps.empty()) break;
    for (std::size_t i = 0; i + tools_ <= sweeps.size(); i += tools_, ++parcel->at_tick)
      catch_up_.step(*parcel->model, std::span(sweeps).subspan(i, tools_));
  }
  show(*message);
  {
    const std::scoped_lock lock(guard_);
    ++arrived_;
    ways_[parcel->frame] = {message->body_ms, came_at};
  }
  ticks_.put(std::move(parcel));
}

void ModelWorker::show(const ModelMessage& message) {
  const SentModel& m = message.model;
  VectorX x = unpacker_.positions_of(m);
  const std::scoped_lock lock(guard_);
  loss_ = message.loss;
  x_ = std::move(x);
  status_.refreshes = m.frame + 1;
  status_.linearized_tick = m.linearized_tick;
  status_.dof = m.dof();
  status_.patch_vertices = static_cast<int>(m.du.size() / 3);
  status_.fineness = m.fine ? m.fine->fineness : std::numeric_limits<double>::quiet_NaN();
  status_.force_factor = message.force_factor;
  status_.refresh_ms = message.refresh_ms;
  status_.expected_force_error = message.expected_force_error;
  status_.certified_error = m.certified_error;
  status_.reducer = m.reducer;
}

/// Looks at some ticks of a local model that is not in use any more.
bool ModelWorker::look_back(int ticks) {
  std::unique_lock lock(guard_);
  if (past_.empty()) return false;
  PreparedLocalModel& oldest = *past_.front();
  if (past_.size() > kMostWaiting) ticks = std::numeric_limits<int>::max();
  lock.unlock();
  if (observer_->look_back(oldest, ticks)) return true;
  lock.lock();
  past_.pop_front();
  return true;
}

}  // namespace kt
