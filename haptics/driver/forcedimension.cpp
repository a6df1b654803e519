// Force Dimension omega, delta, sigma, lambda, and Novint Falcon: by the maker's DHD. Its calls wait for the USB bus,
// so a thread of ours goes round as fast as they return: pose to its slot, order from its slot.
//
// Never tried on hardware. The device's frame is the maker's: x towards the person, y to the right, z up.
#include <memory>
#include <optional>
#include <thread>

#include "haptics/driver/dhd.hpp"
#include "haptics/driver/find_devices.hpp"
#include "haptics/driver/live_device.hpp"
#include "haptics/driver/put_reading.hpp"

namespace kt {
namespace {

std::string dhd_serial(const dhd::Library& dhd, char id) {
  unsigned short serial = 0;
  return dhd.serial(&serial, id) < 0 ? "" : std::to_string(serial);
}

/// All that are connected, opened one after the other to ask for their serial number. `id`: serial number.
std::vector<FoundDevice> look_at_dhd(const dhd::Library& dhd) {
  std::vector<FoundDevice> out;
  for (int i = 0; i < dhd.count(); ++i) {
    const char id = static_cast<char>(i);
    FoundDevice found{"forcedimension", std::to_string(i), "", ""};
    if (dhd.open(id) < 0) {
      found.trouble = dhd.last_error();
    } else {
      if (const std::string serial = dhd_serial(dhd, id); !serial.empty()) found.id = serial;
      found.name = dhd.name(id);
      int status[64] = {};  // later versions may have more than 17
      if (dhd.status(status, id) >= 0 && status[dhd::kReset] == 0)
        found.trouble = "not calibrated: " + calibration_advice("forcedimension");
      dhd.close(id);
    }
    out.push_back(found);
  }
  return out;
}

/// Where among the connected ones. Throws InputError.
char dhd_index(const dhd::Library& dhd, const std::string& id) {
  const int count = dhd.count();
  if (count <= 0)
    throw InputError(
        "tool.path.device: forcedimension: no device is connected, or it may not be opened "
        "(the maker's rules for udev give the right to)");
  if (count == 1 && id.empty()) return 0;
  std::vector<std::string> ids;
  for (const FoundDevice& found : look_at_dhd(dhd)) ids.push_back(found.id);
  for (std::size_t i = 0; i < ids.size(); ++i)
    if (!id.empty() && (ids[i] == id || std::to_string(i) == id)) return static_cast<char>(i);
  throw_which_device("forcedimension", id, ids);
}

class ForceDimension final : public DeviceDriver {
 public:
  ForceDimension(const DeviceSettings& settings, DeviceSlots& slots)
      : slots_(slots), dhd_(settings.library), id_(dhd_index(dhd_, settings.id)) {
    if (dhd_.open(id_) < 0) throw InputError(text("tool.path.device: forcedimension: ", dhd_.last_error()));
    info_.name = dhd_.name(id_);
    info_.serial = dhd_serial(dhd_, id_);
    info_.senses_turn = dhd_.has_wrist(id_);
    info_.gives_torque = dhd_.has_active_wrist(id_);
    info_.delay = 1e-3;  // until it is measured
    if (const double most = dhd_.max_force ? dhd_.max_force(id_) : -1; most > 0) info_.max_force = most;
    begin();
    thread_ = std::thread([this] { run(); });
  }

  ~ForceDimension() override {
    is_closing_.store(true, std::memory_order_relaxed);
    thread_.join();
    slots_.health.store(DeviceHealth::gone, std::memory_order_relaxed);
  }

  DeviceInfo info() const override { return info_; }

 private:
  void begin() noexcept {
    dhd_.compensate_gravity(dhd::kOn, id_);
    dhd_.enable_force(dhd::kOn, id_);
  }

  void run() noexcept {
    std::int64_t close_at = 0;
    while (close_at == 0 || monotonic_ns() < close_at) {
      const bool is_closing = is_closing_.load(std::memory_order_relaxed);
      if (is_closing && close_at == 0) close_at = monotonic_ns() + 50'000'000;
      if (!is_open_ && is_closing) return;
      if (is_open_ || reopen()) turn_round(is_closing);
    }
    dhd_.enable_force(dhd::kOff, id_);
    dhd_.close(id_);
  }

  void turn_round(bool is_closing) noexcept {
    const std::int64_t now = monotonic_ns();
    const int state = read(now);
    // Asked for after the bus has been waited for: an order grows old meanwhile.
    const DeviceOrder order = is_closing ? DeviceOrder{} : slots_.wanted(monotonic_ns());
    if (write(order) < 0 || state < 0) return lose();
    look_at_status(now);
    if (state == kTooSoon) std::this_thread::sleep_for(std::chrono::microseconds(100));
  }

  /// Negative: no answer. A pose that is not finite is not put into the slot: the last one stays, and ages.
  int read(std::int64_t now) noexcept {
    double x[3], v[3], frame[3][3];
    const int state = dhd_.position(&x[0], &x[1], &x[2], id_);
    if (state < 0) return state;
    Quaternion turn = Quaternion::Identity();
    if (info_.senses_turn) {
      if (dhd_.orientation(frame, id_) < 0 || !all_finite(&frame[0][0], 9)) return state;
      Mat3 r;
      for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) r(row, column) = frame[row][column];
      turn = Quaternion(r).normalized();
    }
    if (dhd_.velocity(&v[0], &v[1], &v[2], id_) < 0) v[0] = std::numeric_limits<double>::quiet_NaN();
    if (!all_finite(x, 3) || !turn.coeffs().allFinite()) return state;
    for (int i = 0; i < 3; ++i) {
      reading_.x[i] = x[i];
      reading_.v[i] = v[i];
    }
    put_reading(slots_, reading_, turn, dhd_.buttons(id_), now);
    return state;
  }

  int write(const DeviceOrder& order) noexcept {
    const double(&f)[3] = order.force, (&m)[3] = order.torque;
    return info_.gives_torque ? dhd_.set_wrench(f[0], f[1], f[2], m[0], m[1], m[2], 0, id_)
                              : dhd_.set_force(f[0], f[1], f[2], id_);
  }

  void look_at_status(std::int64_t now) noexcept {
    int status[64] = {};
    if (dhd_.status(status, id_) < 0) return lose();
    DeviceHealth health = DeviceHealth::ok;
    const bool is_wrist_ready = !info_.gives_torque || status[dhd::kWristReady] != 0;
    if (status[dhd::kReset] == 0 || !is_wrist_ready) health = DeviceHealth::uncalibrated;
    if (status[dhd::kError] != 0) health = DeviceHealth::fault;
    if (status[dhd::kConnected] == 0) health = DeviceHealth::gone;
    if (status[dhd::kPower] == 0) health = DeviceHealth::unpowered;
    if (status[dhd::kForceOn] == 0 && health == DeviceHealth::ok) {
      const int cause = status[dhd::kForceOffCause];
      health = cause == dhd::kUsb ? DeviceHealth::gone : DeviceHealth::fault;
      // A person's button and the dead man's switch are theirs to release.
      if (cause != dhd::kButton && cause != dhd::kDeadMan && now - enabled_at_ > kRetry_ns) {
        dhd_.enable_force(dhd::kOn, id_);
        enabled_at_ = now;
      }
    } else {
      enabled_at_ = now;
    }
    slots_.health.store(health, std::memory_order_relaxed);
  }

  void lose() noexcept {
    slots_.health.store(DeviceHealth::gone, std::memory_order_relaxed);
    dhd_.close(id_);
    is_open_ = false;
    tried_at_ = monotonic_ns();
  }

  /// Five times a second, the same device: by its serial number when others are there too.
  bool reopen() noexcept {
    if (monotonic_ns() - tried_at_ < kRetry_ns) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      return false;
    }
    tried_at_ = monotonic_ns();
    for (int i = 0; i < dhd_.count(); ++i) {
      const char id = static_cast<char>(i);
      if (dhd_.open(id) < 0) continue;
      if (dhd_serial(dhd_, id) == info_.serial) {
        id_ = id;
        is_open_ = true;
        begin();
        return true;
      }
      dhd_.close(id);
    }
    return false;
  }

  static constexpr int kTooSoon = 1;
  static constexpr std::int64_t kRetry_ns = 200'000'000;

  DeviceSlots& slots_;
  dhd::Library dhd_;
  char id_;
  DeviceInfo info_;
  std::atomic<bool> is_closing_{false};
  // Of the thread alone:
  bool is_open_ = true;
  DeviceReading reading_;
  std::int64_t tried_at_ = 0, enabled_at_ = 0;
  std::thread thread_;
};

std::unique_ptr<DeviceDriver> open_forcedimension(const DeviceSettings& settings, DeviceSlots& slots) {
  return std::make_unique<ForceDimension>(settings, slots);
}

}  // namespace

std::unique_ptr<HapticDevice> make_forcedimension_device(const DeviceOptions& options) {
  return make_live_device(options, open_forcedimension);
}

std::vector<FoundDevice> find_forcedimension_devices(const DeviceSettings& settings) {
  try {
    std::vector<FoundDevice> out = look_at_dhd(dhd::Library(settings.library));
    if (!settings.id.empty()) std::erase_if(out, [&](const FoundDevice& found) { return found.id != settings.id; });
    return out;
  } catch (const InputError& e) {
    return {{"forcedimension", "", "", e.what()}};
  }
}

}  // namespace kt
