// 6-axis mouse (SpaceMouse and the like), by the daemon spacenavd: its cap's deflection is the tool's speed. No force.
//
// Spoken with the daemon's UNIX socket itself, protocol 0 (proto.h of libspnav 1.0): eight 32-bit integers an event, in
// the computer's byte order, and nothing to send. libspnav does not serve here: Debian's needs libX11 in every program,
// it has one connection a process, whose socket can only be named in the environment, and it does not say that the
// daemon is gone.
//
// Never tried on hardware. The device's frame: x to the right, y away from the person, z up.
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <thread>

#include "haptics/driver/find_devices.hpp"
#include "haptics/driver/live_device.hpp"

namespace kt {
namespace {

std::string spnav_socket(const DeviceSettings& settings) {
  if (!settings.address.empty()) return settings.address;
  const char* const named = std::getenv("SPNAV_SOCKET");
  return named ? named : "/var/run/spnav.sock";
}

/// A connection to the daemon; closed, it has no file.
class SpnavSocket {
 public:
  ~SpnavSocket() { close(); }

  /// 0, or what went wrong (errno).
  int open(const std::string& path) noexcept {
    close();
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.size() >= sizeof address.sun_path) return ENAMETOOLONG;
    path.copy(address.sun_path, path.size());
    file_ = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (file_ < 0) return errno;
    if (connect(file_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return 0;
    const int error = errno;
    close();
    return error;
  }
  void close() noexcept {
    if (file_ >= 0) ::close(file_);
    file_ = -1;
    filled_ = 0;
  }
  bool is_open() const noexcept { return file_ >= 0; }

  /// The next event, if one has come in whole. Closes when the daemon has.
  bool next(std::array<std::int32_t, 8>& event) noexcept {
    while (is_open()) {
      const ssize_t got = recv(file_, buffer_ + filled_, sizeof buffer_ - filled_, 0);
      if (got < 0 && errno == EINTR) continue;
      if (got == 0 || (got < 0 && errno != EAGAIN)) close();
      if (got <= 0) return false;
      filled_ += static_cast<std::size_t>(got);
      if (filled_ < sizeof buffer_) continue;
      std::memcpy(event.data(), buffer_, sizeof buffer_);
      filled_ = 0;
      return true;
    }
    return false;
  }

 private:
  int file_ = -1;
  char buffer_[32];
  std::size_t filled_ = 0;
};

class Spnav final : public DeviceDriver {
 public:
  Spnav(const DeviceSettings& settings, DeviceSlots& slots)
      : slots_(slots), path_(spnav_socket(settings)), speed_(settings.speed) {
    if (const int error = socket_.open(path_); error != 0)
      throw InputError(text("tool.path.device: spnav: ", path_, ": ", std::strerror(error), "; is spacenavd running?"));
    thread_ = std::thread([this] { run(); });
  }
  ~Spnav() override {
    is_closing_.store(true, std::memory_order_relaxed);
    thread_.join();
    slots_.health.store(DeviceHealth::gone, std::memory_order_relaxed);
  }
  DeviceInfo info() const override {
    return {.gives_force = false, .senses_turn = true, .name = "6-axis mouse (spacenavd)"};
  }

 private:
  void run() noexcept {
    std::int64_t before = monotonic_ns(), due = before;
    while (!is_closing_.load(std::memory_order_relaxed)) {
      const std::int64_t now = monotonic_ns();
      listen(now);
      if (socket_.is_open()) move(now, 1e-9 * static_cast<double>(std::min<std::int64_t>(now - before, 5'000'000)));
      before = now;
      due = std::max(due + 1'000'000, now);  // what was missed is not made up for
      const timespec until{due / 1'000'000'000, due % 1'000'000'000};
      clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
    }
  }

  void listen(std::int64_t now) noexcept {
    if (!socket_.is_open()) {
      if (now - tried_at_ < 1'000'000'000) return;
      tried_at_ = now;
      if (socket_.open(path_) != 0) return;
    }
    std::array<std::int32_t, 8> event;
    while (socket_.next(event)) take(event, now);
    if (now - moved_at_ > 100'000'000) deflection_ = {};
    if (!socket_.is_open()) {
      deflection_ = {};
      reading_.buttons = 0;
      tried_at_ = now;
    }
    slots_.health.store(socket_.is_open() ? DeviceHealth::ok : DeviceHealth::gone, std::memory_order_relaxed);
  }

  void take(const std::array<std::int32_t, 8>& event, std::int64_t now) noexcept {
    enum { kMotion, kPress, kRelease };
    constexpr double kFull = 350;  // of the cap, in the daemon's units
    if (event[0] == kMotion) {
      for (std::size_t i = 0; i < 6; ++i) deflection_[i] = std::clamp(event[i + 1] / kFull, -1.0, 1.0);
      moved_at_ = now;
    } else if ((event[0] == kPress || event[0] == kRelease) && event[1] >= 0 && event[1] < 32) {
      const std::uint64_t bit = std::uint64_t{1} << event[1];
      reading_.buttons = event[0] == kPress ? reading_.buttons | bit : reading_.buttons & ~bit;
    }
  }

  /// The daemon's axes: x to the right, y up, z away; turns about the same.
  void move(std::int64_t now, double h) noexcept {
    constexpr double kLever = 0.1;  // [m]: at full deflection the tool turns as fast as a point at that distance moves
    const Vec3 v = speed_ * Vec3(deflection_[0], deflection_[2], deflection_[1]);
    const Vec3 w = speed_ / kLever * Vec3(deflection_[3], deflection_[5], deflection_[4]);
    if (const double angle = h * w.norm(); angle > 0)
      turn_ = (Quaternion(Eigen::AngleAxisd(angle, w.normalized())) * turn_).normalized();
    for (int i = 0; i < 3; ++i) {
      reading_.x[i] += h * v[i];
      reading_.v[i] = v[i];
    }
    reading_.turn[0] = turn_.w();
    reading_.turn[1] = turn_.x();
    reading_.turn[2] = turn_.y();
    reading_.turn[3] = turn_.z();
    reading_.at_ns = now;
    ++reading_.count;
    slots_.reading.put(reading_);
  }

  DeviceSlots& slots_;
  const std::string path_;
  const double speed_;
  SpnavSocket socket_;
  std::atomic<bool> is_closing_{false};
  // Of the thread alone:
  DeviceReading reading_;
  Quaternion turn_ = Quaternion::Identity();
  std::array<double, 6> deflection_{};  // -1 .. 1
  std::int64_t moved_at_ = 0, tried_at_ = 0;
  std::thread thread_;
};

std::unique_ptr<DeviceDriver> open_spnav(const DeviceSettings& settings, DeviceSlots& slots) {
  return std::make_unique<Spnav>(settings, slots);
}

}  // namespace

std::unique_ptr<HapticDevice> make_spnav_device(const DeviceOptions& options) {
  return make_live_device(options, open_spnav);
}

std::vector<FoundDevice> find_spnav_devices(const DeviceSettings& settings) {
  const std::string path = spnav_socket(settings);
  if (const int error = SpnavSocket().open(path); error != 0)
    return {{"spnav", "", "", text(path, ": ", std::strerror(error), "; is spacenavd running?")}};
  return {{"spnav", path, "6-axis mouse (spacenavd)", ""}};
}

}  // namespace kt
