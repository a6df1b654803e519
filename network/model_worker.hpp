#pragma once
// Local models from bytes: unpacked, checked and brought to the present, in a thread of its own, so that what sends and
// receives goes on meanwhile.
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <thread>

#include "haptics/body/body.hpp"
#include "haptics/halves/swap_energy.hpp"
#include "haptics/halves/touch_status.hpp"
#include "haptics/remote/model_unpacker.hpp"
#include "haptics/remote/yield_memory.hpp"
#include "haptics/tick/catch_up.hpp"
#include "haptics/touch/tick_end.hpp"
#include "network/hand_link.hpp"
#include "network/message/messages.hpp"
#include "network/shared_history.hpp"

namespace kt {

class ModelWorker {
 public:
  /// @param ticks, history  borrowed: where models go, and along which sweeps they catch up
  ModelWorker(const Body& body, const TouchOptions& options, const SurfaceFriction& friction, ModelObserver* observer,
              TickEnd& ticks, const SharedHistory& history);

  /// Of the start, in the caller's thread. Throws RunError: it does not fit.
  std::unique_ptr<PreparedLocalModel> first(const ModelMessage& message);
  void start();
  void stop();

  /// The newest wins.
  /// @param tick0  of the server's first tick
  void put(Bytes bytes, int tick0);
  struct Way {
    double body_ms = 0;
    int came_at = 0;  ///< tick
  };
  /// How a model came, once.
  std::optional<Way> take_way(int frame);
  /// The ticks' motion goes to the body. From any thread.
  void note(const LocalMotion& motion);
  /// Another session begins: what was noted is of the one before.
  void forget();
  /// A model that was in use.
  void look_back_on(std::unique_ptr<PreparedLocalModel> model);

  TouchStatus status() const;
  void copy_positions(VectorX& x) const;
  void set_late(int ticks);
  void fail(const std::string& why);
  void add_to(HandLinkReport& report) const;
  std::optional<double> loss() const;

 private:
  void run();
  void refuse(const std::string& why);
  void unpack(const Bytes& bytes, int tick0, int came_at);
  void show(const ModelMessage& message);
  bool look_back(int ticks);

  ModelUnpacker unpacker_;
  std::size_t tools_;
  ModelObserver* observer_;
  TickEnd& ticks_;
  const SharedHistory& history_;
  CatchUp catch_up_;
  std::thread thread_;
  mutable std::mutex guard_;  // of what follows
  std::condition_variable came_;
  bool stop_ = false;
  Bytes bytes_;
  YieldMemory yields_;
  std::map<int, Way> ways_;  // by frame, of models that were not adopted yet
  int tick0_ = 0, came_at_ = 0, arrived_ = 0, wrong_ = 0;
  std::optional<double> loss_;
  std::string trouble_;
  std::deque<std::unique_ptr<PreparedLocalModel>> past_;
  SwapEnergy swaps_;
  TouchStatus status_;
  VectorX x_;
};

}  // namespace kt
