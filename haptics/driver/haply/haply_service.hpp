#pragma once
// What Haply's service tells beside its WebSocket of states: settings by HTTP, events by a WebSocket of their own.
#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace kt {

struct HaplyAddress {
  std::string host, port;
  std::string url() const { return "ws://" + host + ":" + port; }
};

/// "ws://HOST:PORT"; empty: the usual one. Throws InputError.
HaplyAddress parse_haply_address(const std::string& address);

/// A number among the service's settings, by HTTP; none: the service does not say (older ones have no such channel).
std::optional<double> ask_haply_setting(const HaplyAddress& address, const std::string& key);

/// What has been said so far, each sentence once; from several threads.
class HaplyNotes {
 public:
  void add(const std::string& note);
  std::vector<std::string> list() const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, int> notes_;
};

/// In a thread of its own, beside the ticks: events of one device, and what scales its forces.
class HaplyWatch {
 public:
  /// @param events_port  of the channel   @param tells_scale  the service has said its force_scale before: look again
  HaplyWatch(HaplyAddress address, std::string device, int events_port, bool tells_scale, HaplyNotes& notes);
  ~HaplyWatch();

  bool has_braked() const noexcept { return has_braked_; }  ///< its emergency brake is on
  bool is_scaled() const noexcept { return is_scaled_; }    ///< forces reach the motors larger or smaller

 private:
  void run();
  void listen();
  void take(const std::string& message);
  void look_at_scale();

  HaplyAddress address_;
  std::string device_;
  int events_port_;
  bool tells_scale_;
  HaplyNotes& notes_;
  std::atomic<bool> is_closing_{false}, has_braked_{false}, is_scaled_{false};
  std::thread thread_;
};

}  // namespace kt
