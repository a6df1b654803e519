// Haply Inverse3 by its service: a WebSocket on this computer, JSON both ways, no library of the vendor.
//
// Never tried on hardware, nor with the maker's service.
#include <thread>

#include <boost/system/system_error.hpp>

#include "haptics/driver/find_devices.hpp"
#include "haptics/driver/haply/haply_connection.hpp"
#include "haptics/driver/live_device.hpp"
#include "haptics/machine/real_time_thread.hpp"

namespace kt {
namespace {

constexpr double kUsualForce = 3;  // [N] limits are in none of the service's messages
constexpr int kUsualEventsPort = 10020;
constexpr double kQuarterTurn = 1.5707963267948966;  // [rad] from z to the pen's -y, as a pen points along its +y

[[noreturn]] void refuse(const HaplyAddress& address, const std::string& why) {
  throw InputError(
      text("tool.path.device: ", address.url(), ": ", why, "; is the Haply Inverse Service running there?"));
}

/// Why a device cannot be used now; empty: it can, as far as it says.
std::string trouble_of(const HaplyStatus& status) {
  if (status.is_in_use) return "another program uses it (see the sessions in Haply Hub)";
  if (!status.has_power) return "it has no power: connect its supply";
  if (!status.is_calibrated) return "not calibrated: " + calibration_advice("haply");
  return {};
}

/// The device that is meant among those that are there.
const HaplyListed& choose(const HaplyAddress& address, const HaplyState& inventory, const std::string& id) {
  if (inventory.devices.empty())
    throw InputError(text("tool.path.device: ", address.url(),
                          ": the Haply Inverse Service lists no Inverse3; is it plugged in and switched on?"));
  if (id.empty() && inventory.devices.size() == 1) return inventory.devices.front();
  std::vector<std::string> ids;
  for (const HaplyListed& one : inventory.devices) ids.push_back(one.id);
  if (id.empty())
    throw InputError(text("tool.path.device.id: there are several Inverse3: ", join(ids), "; name one (--id)"));
  const auto at = std::ranges::find(ids, id);
  if (at == ids.end()) throw_unknown("tool.path.device.id", id, ids);
  return inventory.devices[static_cast<std::size_t>(at - ids.begin())];
}

/// Throws InputError for a service that makes other forces of ours.
bool check_force_scale(const HaplyAddress& address, HaplyNotes& notes) {
  const auto scale = ask_haply_setting(address, "devices/force_scale");
  if (!scale) notes.add("the service does not say its devices/force_scale: forces may be scaled");
  if (scale && *scale != 1)
    throw InputError(text("tool.path.device: ", address.url(), ": the service's devices/force_scale is ", *scale,
                          ", so that forces are not the ones that are computed; set it to 1 (Haply Hub, settings)"));
  return scale.has_value();
}

class Haply final : public DeviceDriver {
 public:
  Haply(const DeviceSettings& settings, DeviceSlots& slots)
      : session_{.address = parse_haply_address(settings.address),
                 .id = settings.id,
                 .grip = {},
                 .service_damping = settings.service_damping,
                 .slots = slots,
                 .notes = notes_,
                 .is_closing = is_closing_} {
    const bool tells_scale = check_force_scale(session_.address, notes_);
    auto first = connect();
    const double port = ask_haply_setting_or(tells_scale, "communication/events/port", kUsualEventsPort);
    watch_ = std::make_unique<HaplyWatch>(session_.address, session_.id, static_cast<int>(port), tells_scale, notes_);
    session_.watch = watch_.get();
    thread_ = std::thread([this, first = std::move(first)]() mutable { run(std::move(first)); });
  }
  ~Haply() override {
    is_closing_ = true;
    thread_.join();
  }
  DeviceInfo info() const override {
    DeviceInfo out;
    out.max_force = kUsualForce;
    out.senses_turn = !session_.grip.empty();
    out.pen_turn = {kQuarterTurn, 0, 0};
    out.delay_is_of_messages = true;
    out.workspace_radius = haply_reach(type_);
    out.name = haply_name(type_);
    out.serial = session_.id;
    return out;
  }
  std::vector<std::string> notes() const override { return notes_.list(); }

 private:
  double ask_haply_setting_or(bool has_settings, const char* key, double usual) const {
    return has_settings ? ask_haply_setting(session_.address, key).value_or(usual) : usual;
  }

  /// A connection to a device that may be used. Throws InputError.
  std::unique_ptr<HaplyConnection> connect() {
    try {
      auto out = std::make_unique<HaplyConnection>(session_);
      HaplyState inventory = out->inventory(2000);
      const HaplyListed device = choose(session_.address, inventory, session_.id);
      if (device.status.is_in_use)
        throw InputError(text("tool.path.device: haply ", device.id, ": ", trouble_of(device.status)));
      if (session_.id.empty()) session_.id = device.id;
      if (type_.empty()) type_ = device.type;
      if (session_.grip.empty()) session_.grip = inventory.grip;
      if (session_.grip.empty() && inventory.grips > 1)
        notes_.add(text(inventory.grips, " grips, none of them paired with ", device.id,
                        ": no turn is read; pair one (Haply Hub)"));
      if (const std::string altered = out->introduce(inventory.key); !altered.empty())
        throw InputError(text("tool.path.device: haply ", device.id, ": the service keeps ", altered,
                              " for the profile org.kilotouch, so that places are not in metres of the device; set it "
                              "back (Haply Hub, sessions)"));
      return out;
    } catch (const boost::system::system_error& e) {
      refuse(session_.address, e.code().message());
    }
  }

  /// A connection that is lost is opened again, once a second.
  void run(std::unique_ptr<HaplyConnection> connection) {
    const RealTimeThread on_time({.priority = kIoPriority, .locks_memory = false});  // as far as it is granted
    for (;;) {
      if (connection) connection->run();
      connection.reset();
      session_.slots.health = DeviceHealth::gone;
      for (int i = 0; i < 50 && !is_closing_; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
      if (is_closing_) return;
      try {
        connection = connect();
      } catch (const std::exception&) {
        // Not there yet.
      }
    }
  }

  HaplyNotes notes_;
  std::atomic<bool> is_closing_{false};
  HaplySession session_;  // of the thread alone, once it runs; its id and grip stay
  std::string type_;
  std::unique_ptr<HaplyWatch> watch_;
  std::thread thread_;
};

std::unique_ptr<DeviceDriver> open_haply(const DeviceSettings& settings, DeviceSlots& slots) {
  return std::make_unique<Haply>(settings, slots);
}

}  // namespace

std::unique_ptr<HapticDevice> make_haply_device(const DeviceOptions& options) {
  return make_live_device(options, open_haply);
}

std::vector<FoundDevice> find_haply_devices(const DeviceSettings& settings) {
  const HaplyAddress address = parse_haply_address(settings.address);
  const std::atomic<bool> is_closing{false};
  DeviceSlots none;
  HaplyNotes notes;
  HaplySession session{
      .address = address, .id = {}, .grip = {}, .slots = none, .notes = notes, .is_closing = is_closing};
  try {
    const HaplyState inventory = HaplyConnection(session).inventory(1000);
    std::vector<FoundDevice> out;
    for (const HaplyListed& one : inventory.devices)
      if (settings.id.empty() || settings.id == one.id)
        out.push_back({"haply", one.id, haply_name(one.type), trouble_of(one.status)});
    if (inventory.devices.empty())
      out.push_back(
          {"haply", "", "", text(address.url(), ": the service lists no Inverse3; is it plugged in and switched on?")});
    return out;
  } catch (const boost::system::system_error& e) {
    return {
        {"haply", "", "", text(address.url(), ": ", e.code().message(), "; is the Haply Inverse Service running?")}};
  }
}

}  // namespace kt
