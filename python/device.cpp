#include "python/bindings.hpp"
#include "python/device_reading.hpp"

namespace kt {
namespace {

DeviceHealth health_of(const std::string& name) {
  std::vector<std::string> known;
  for (const DeviceHealth health :
       {DeviceHealth::ok, DeviceHealth::stale, DeviceHealth::gone, DeviceHealth::fault, DeviceHealth::uncalibrated}) {
    if (name == name_of(health)) return health;
    known.emplace_back(name_of(health));
  }
  throw_unknown("health", name, known);
}

Vec3 finite_vector(const py::object& given, const char* what) {
  const Floats values = numbers_of(given, what, "3 of them");
  if (values.ndim() != 1 || values.size() != 3) throw InputError(text(what, ": 3 numbers are needed"));
  const Vec3 out(values.data()[0], values.data()[1], values.data()[2]);
  if (!out.allFinite()) throw InputError(text(what, ": a number is not finite"));
  return out;
}

DeviceReadingAt make_reading(const py::object& pose, double age, const std::string& health, unsigned buttons,
                             double delay, unsigned delays, const py::object& v) {
  if (!(age >= 0)) throw InputError(text("age: ", age, ", must be at least 0 [s]"));
  if (!(delay >= 0 && std::isfinite(delay))) throw InputError(text("delay: ", delay, ", must be at least 0 [s]"));
  DeviceReadingAt out{device_pose_of(pose), {health_of(health), age, buttons, delay, delays, {}}};
  if (!v.is_none()) out.state.v = finite_vector(v, "v");
  return out;
}

void push(PushedDevice& device, const py::object& given, unsigned buttons, const py::object& v, double age) {
  const Pose pose = device_pose_of(given);
  if (!(age >= 0)) throw InputError(text("age: ", age, ", must be at least 0 [s]"));
  DeviceReading reading;
  std::copy_n(pose.x.data(), 3, reading.x);
  const double turn[4] = {pose.r.w(), pose.r.x(), pose.r.y(), pose.r.z()};
  std::copy_n(turn, 4, reading.turn);
  if (!v.is_none()) std::copy_n(finite_vector(v, "v").data(), 3, reading.v);
  reading.buttons = buttons;
  reading.at_ns = monotonic_ns() - static_cast<std::int64_t>(1e9 * std::min(age, 1e6));
  reading.count = ++device.count;
  device.slots->reading.put(reading);
  device.slots->health.store(DeviceHealth::ok);
}

py::tuple order_of(const PushedDevice& device) {
  const DeviceOrder order = device.slots->wanted(monotonic_ns());
  return py::make_tuple(Vec3(order.force[0], order.force[1], order.force[2]),
                        Vec3(order.torque[0], order.torque[1], order.torque[2]));
}

}  // namespace

void bind_device(py::module_& m) {
  py::class_<DeviceReadingAt>(m, "DeviceReading", "Pose and state of a device, for Touch.tick_device().")
      .def(py::init(&make_reading), py::arg("pose"), py::arg("age") = 0.0, py::arg("health") = "ok",
           py::arg("buttons") = 0U, py::arg("delay") = 0.0, py::arg("delays") = 0U, py::arg("v") = py::none(),
           "pose is (3,) [m] or (7,), with the turn as a quaternion w x y z, in the world's frame, age that of the "
           "pose [s]. "
           "health is ok, stale, gone, fault or uncalibrated. Bit 0 of buttons is the first. delay is the time from a "
           "force "
           "that was written until it acted, as measured last [s], delays the number of measurements. v is the "
           "device's own "
           "velocity (3,) [m/s].");
  py::class_<PushedDevice, std::shared_ptr<PushedDevice>>(
      m, "PushedDevice",
      "A device that Python drives, with poses in and forces out. The scene's tool.path.device.name is "
      "pushed. Session.start(pushed=device) ticks it at the haptic rate in a thread of its own.")
      .def(py::init<>())
      .def("push", &push, py::arg("pose"), py::arg("buttons") = 0U, py::arg("v") = py::none(), py::arg("age") = 0.0,
           "Pose of the device now, (3,) [m] or (7,), in its own frame. A pose that is older than 5 ms shuts the "
           "gate, so push at 250 Hz or more, and a first one before start(). age is the time since it was read [s].")
      .def_property_readonly(
          "order", &order_of,
          "The force to write to the device now, (force (3,) [N], torque (3,) [N m]), in its own frame. "
          "Finite, within the limits, zero when no tick has come for 20 ms. Read it after calls that "
          "may block.")
      .def_property(
          "health", [](const PushedDevice& d) { return name_of(d.slots->health.load()); },
          [](PushedDevice& d, const std::string& name) { d.slots->health.store(health_of(name)); },
          "ok, stale, gone, fault or uncalibrated. All but ok shut the gate. push() sets it to ok.");
}

}  // namespace kt
