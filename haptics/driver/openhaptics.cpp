// 3D Systems Touch, Touch X, Phantom: by OpenHaptics' HDAPI. The maker's scheduler calls us 1000 times a second, in its
// own thread; that call is the whole I/O: errors, pose to its slot, order from its slot.
//
// Never tried on hardware. The device's frame is the maker's, in m: x to the right, y up, z towards the person.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <thread>

#include "haptics/driver/find_devices.hpp"
#include "haptics/driver/hdapi.hpp"
#include "haptics/driver/live_device.hpp"
#include "haptics/driver/put_reading.hpp"

namespace kt {
namespace {

constexpr double kPerMm = 1e-3;

/// The library and the devices that were opened with it, until the process ends: opened again after a close, its
/// drivers are known to fail (CHAI3D's notes), so nothing is ever closed before.
struct OpenedHd {
  explicit OpenedHd(const std::string& file) : hd(file) {}

  /// Throws InputError when there is no such device.
  unsigned device(const std::string& id) {
    if (const auto found = devices.find(id); found != devices.end()) return found->second;
    while (hd.get_error().code != hd::kNone) {
    }
    const unsigned handle = hd.init(id.empty() ? nullptr : id.c_str());
    const hd::ErrorInfo error = hd.get_error();
    if (error.code != hd::kNone || handle == hd::kNoDevice)
      throw InputError(text("tool.path.device: openhaptics: ", id.empty() ? "the default device" : "\"" + id + "\"",
                            " does not open (error 0x", std::hex, error.code, ", internal ", std::dec, error.internal,
                            "); is it connected, and set up with the maker's program?"));
    return devices[id] = handle;
  }

  void close() noexcept {
    if (devices.empty()) return;
    hd.stop_scheduler();
    for (const auto& [id, handle] : devices) hd.disable_device(handle);
    devices.clear();
  }

  hd::Library hd;
  std::map<std::string, unsigned> devices;
  bool is_running = false;
};

std::mutex hd_mutex;  // of the map below; never in a tick

OpenedHd& opened_hd(const std::string& file) {
  static auto* const all = new std::map<std::string, std::unique_ptr<OpenedHd>>;
  std::unique_ptr<OpenedHd>& one = (*all)[file];
  if (one) return *one;
  const bool is_first = all->size() == 1;
  try {
    one = std::make_unique<OpenedHd>(file);
  } catch (...) {
    all->erase(file);
    throw;
  }
  if (is_first)  // registered after the library's own end, so run before it
    std::atexit([] {
      for (auto& [name, hd] : *all)
        if (hd) hd->close();
    });
  return *one;
}

/// Names of the devices that the maker's program has set up: its files NAME.config.
std::vector<std::string> hd_names() {
  const char* const home = std::getenv("GTDD_HOME");
  std::vector<std::string> out;
  std::error_code none;
  for (const auto& file : std::filesystem::directory_iterator(
           std::filesystem::path(home ? home : "/usr/share/3DSystems") / "config", none))
    if (file.path().extension() == ".config") out.push_back(file.path().stem().string());
  std::sort(out.begin(), out.end());
  return out;
}

std::string hd_id(const DeviceSettings& settings) {
  if (!settings.id.empty()) return settings.id;
  const std::vector<std::string> names = hd_names();
  if (names.size() > 1) throw_which_device("openhaptics", "", names);
  return names.empty() ? "" : names[0];
}

/// What the maker's scheduler calls: one servo period of one device.
class HdServo {
 public:
  HdServo(const hd::Library& hd, unsigned device, DeviceSlots& slots) : hd_(hd), device_(device), slots_(slots) {}

  static int call(void* self) noexcept { return static_cast<HdServo*>(self)->serve(); }

  /// Zeros for 50 ms, then no more calls. False: the scheduler has not called for 2 s, and may yet.
  bool close() noexcept {
    close_at_.store(monotonic_ns() + 50'000'000, std::memory_order_relaxed);
    for (int i = 0; i < 1000 && !is_done_.load(std::memory_order_acquire); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return is_done_.load(std::memory_order_acquire);
  }

 private:
  int serve() noexcept {
    const std::int64_t close_at = close_at_.load(std::memory_order_relaxed);
    hd_.begin_frame(device_);
    const std::int64_t now = monotonic_ns();
    if (close_at != 0) {
      hd_.set_doubles(hd::kForce, DeviceOrder{}.force);
      hd_.end_frame(device_);
      if (now < close_at) return hd::kContinue;
      is_done_.store(true, std::memory_order_release);
      return hd::kDone;
    }
    drain_errors(now);
    if (frames_++ % kCalibrationEvery == 0) calibrate();
    if (now >= gone_until_) read(now);
    hd_.set_doubles(hd::kForce, slots_.wanted(monotonic_ns()).force);
    hd_.end_frame(device_);
    drain_errors(now);
    slots_.health.store(health(now), std::memory_order_relaxed);
    return hd::kContinue;
  }

  /// A queue: everything in it is of now. Warm motors, too much force or speed: a fault, for half a second after the
  /// last; no connection: gone, until a few frames pass without.
  void drain_errors(std::int64_t now) noexcept {
    for (int i = 0; i < 100; ++i) {
      const unsigned code = hd_.get_error().code;
      if (code == hd::kNone) return;
      if (code >= hd::kForceErrors && code < hd::kDeviceErrors) fault_until_ = now + 500'000'000;
      if (code >= hd::kDeviceErrors && code < hd::kFrameErrors) gone_until_ = now + 5'000'000;
    }
  }

  void calibrate() noexcept {
    const unsigned state = hd_.check_calibration();
    if (state == hd::kNeedsUpdate) {  // it knows where it is now: in the inkwell, or at its stops
      int styles = 0;
      hd_.get_integers(hd::kCalibrationStyle, &styles);
      for (const hd::Style style : {hd::kInInkwell, hd::kAutomatic, hd::kEncoderReset})
        if ((styles & style) != 0) {
          hd_.update_calibration(static_cast<unsigned>(style));
          break;
        }
    }
    is_calibrated_ = state == hd::kCalibrated;
  }

  DeviceHealth health(std::int64_t now) const noexcept {
    if (now < gone_until_) return DeviceHealth::gone;
    if (now < fault_until_) return DeviceHealth::fault;
    return is_calibrated_ ? DeviceHealth::ok : DeviceHealth::uncalibrated;
  }

  void read(std::int64_t now) noexcept {
    double x[3], v[3], frame[16];
    int buttons = 0;
    hd_.get_doubles(hd::kPosition, x);
    hd_.get_doubles(hd::kVelocity, v);
    hd_.get_doubles(hd::kTransform, frame);
    hd_.get_integers(hd::kButtons, &buttons);
    if (!all_finite(x, 3) || !all_finite(frame, 16)) return;  // the last pose stays, and ages
    Mat3 r;
    for (int column = 0; column < 3; ++column)
      for (int row = 0; row < 3; ++row) r(row, column) = frame[4 * column + row];
    const Quaternion turn = Quaternion(r).normalized();
    if (!turn.coeffs().allFinite()) return;
    for (int i = 0; i < 3; ++i) {
      reading_.x[i] = kPerMm * x[i];
      reading_.v[i] = kPerMm * v[i];
    }
    put_reading(slots_, reading_, turn, static_cast<unsigned>(buttons), now);
  }

  static constexpr int kCalibrationEvery = 10;

  const hd::Library& hd_;
  const unsigned device_;
  DeviceSlots& slots_;
  std::atomic<std::int64_t> close_at_{0};  // 0: not yet
  std::atomic<bool> is_done_{false};
  DeviceReading reading_;
  std::int64_t fault_until_ = 0, gone_until_ = 0;
  int frames_ = 0;
  bool is_calibrated_ = false;
};

class OpenHaptics final : public DeviceDriver {
 public:
  OpenHaptics(const DeviceSettings& settings, DeviceSlots& slots) : slots_(slots) {
    const std::lock_guard lock(hd_mutex);
    OpenedHd& opened = opened_hd(settings.library);
    hd_ = &opened.hd;
    device_ = opened.device(hd_id(settings));
    hd_->make_current(device_);
    read_info();
    hd_->enable(hd::kForceOutput);
    slots_.health.store(DeviceHealth::uncalibrated, std::memory_order_relaxed);
    servo_ = std::make_unique<HdServo>(*hd_, device_, slots);
    callback_ = hd_->schedule(&HdServo::call, servo_.get(), hd::kFirst);
    if (!opened.is_running) hd_->start_scheduler();
    opened.is_running = true;
  }

  ~OpenHaptics() override {
    const bool is_done = servo_->close();
    const std::lock_guard lock(hd_mutex);
    if (!is_done) {
      hd_->unschedule(callback_);
      servo_.release();  // a call that is still on its way finds it
    }
    hd_->make_current(device_);
    hd_->disable(hd::kForceOutput);
    slots_.health.store(DeviceHealth::gone, std::memory_order_relaxed);
  }

  DeviceInfo info() const override { return info_; }

 private:
  void read_info() {
    const auto number = [&](unsigned name) {
      double out[3] = {0, 0, 0};
      hd_->get_doubles(name, out);
      return std::isfinite(out[0]) && out[0] > 0 ? out[0] : 0.0;
    };
    info_.name = hd_->get_string(hd::kModel);
    info_.serial = hd_->get_string(hd::kSerial);
    info_.senses_turn = true;
    info_.continuous_force = number(hd::kContinuousForce);
    info_.max_stiffness = number(hd::kMaxStiffness) / kPerMm;
    info_.max_damping = number(hd::kMaxDamping) / kPerMm;
    if (const double most = number(hd::kMaxForce); most > 0) info_.max_force = most;
    int rate = 0;
    hd_->get_integers(hd::kRate, &rate);
    info_.delay = rate > 0 ? 1.0 / rate : 1e-3;  // an order waits for the next call
    double box[6] = {};
    hd_->get_doubles(hd::kWorkspace, box);
    if (all_finite(box, 6))
      info_.workspace_radius =
          0.5 * kPerMm * std::max(0.0, std::min({box[3] - box[0], box[4] - box[1], box[5] - box[2]}));
  }

  DeviceSlots& slots_;
  const hd::Library* hd_ = nullptr;
  unsigned device_ = hd::kNoDevice;
  unsigned long callback_ = 0;
  DeviceInfo info_;
  std::unique_ptr<HdServo> servo_;
};

std::unique_ptr<DeviceDriver> open_openhaptics(const DeviceSettings& settings, DeviceSlots& slots) {
  return std::make_unique<OpenHaptics>(settings, slots);
}

}  // namespace

std::unique_ptr<HapticDevice> make_openhaptics_device(const DeviceOptions& options) {
  return make_live_device(options, open_openhaptics);
}

std::vector<FoundDevice> find_openhaptics_devices(const DeviceSettings& settings) {
  const std::lock_guard lock(hd_mutex);
  std::vector<FoundDevice> out;
  try {
    OpenedHd& opened = opened_hd(settings.library);
    std::vector<std::string> ids = settings.id.empty() ? hd_names() : std::vector<std::string>{settings.id};
    if (ids.empty()) ids.push_back("");
    for (const std::string& id : ids) {
      out.push_back({"openhaptics", id, "", ""});
      try {
        const unsigned device = opened.device(id);
        opened.hd.make_current(device);
        out.back().name = text(opened.hd.get_string(hd::kModel), " ", opened.hd.get_string(hd::kSerial));
        opened.hd.begin_frame(device);
        const unsigned state = opened.hd.check_calibration();
        opened.hd.end_frame(device);
        if (state == hd::kNeedsHand) out.back().trouble = "not calibrated: " + calibration_advice("openhaptics");
      } catch (const InputError& e) {
        out.back().trouble = e.what();
      }
    }
  } catch (const InputError& e) {
    out.push_back({"openhaptics", "", "", e.what()});
  }
  return out;
}

}  // namespace kt
