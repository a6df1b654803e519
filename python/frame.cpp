#include "haptics/tick/local_frame.hpp"

#include "haptics/halves/haptic_side.hpp"

#include "python/bindings.hpp"

namespace kt {

Floats numbers_of(const py::handle& given, const char* what, const char* shape) {
  const auto array = py::array::ensure(given);
  if (!array) PyErr_Clear();
  const bool is_real = array && std::string_view("fiu").find(array.dtype().kind()) != std::string_view::npos;
  if (!is_real) throw InputError(text(what, ": numbers are needed, ", shape));
  return numbers_in<Floats>(array);
}

Pose pose_of(const py::handle& given) {
  constexpr const char* kShape = "3 numbers, x y z [m], or 7, with the turn as a unit quaternion w x y z";
  constexpr double kNearly = 1e-3;
  const Floats values = numbers_of(given, "pose", kShape);
  if (values.ndim() != 1 || (values.size() != 3 && values.size() != 7))
    throw InputError(text("pose: numbers are needed, ", kShape));
  const double* p = values.data();
  Pose out{{p[0], p[1], p[2]}, Quaternion::Identity()};
  if (values.size() == 3) return out;
  out.r = Quaternion(p[3], p[4], p[5], p[6]);
  const double size = out.r.norm();
  if (std::isfinite(size) && std::abs(size - 1) > kNearly)
    throw InputError(text("pose: the quaternion has length ", size, ", must be 1"));
  return out;
}

Pose device_pose_of(const py::handle& given) {
  const Pose pose = pose_of(given);
  if (!pose.is_finite()) throw InputError("pose: a number is not finite; nothing was taken");
  if (!is_usable(pose)) throw InputError("pose: is beyond 1e6 m; nothing was taken");
  return pose;
}

double number_of(const py::handle& given, const char* what) {
  const double number = PyNumber_Check(given.ptr()) ? PyFloat_AsDouble(given.ptr()) : -1;
  if (PyNumber_Check(given.ptr()) && !PyErr_Occurred()) return number;
  PyErr_Clear();
  throw InputError(text(what, ": a number is needed"));
}

std::string path_of(const py::object& path) {
  return py::module_::import("os").attr("fspath")(path).cast<std::string>();
}

py::tuple tuple_of(const Vec3& v) { return py::make_tuple(v[0], v[1], v[2]); }

Vec3 vector_of(const py::handle& three) {
  const auto values = three.cast<std::array<double, 3>>();
  return {values[0], values[1], values[2]};
}

namespace {

py::tuple state_of(const LocalFrame& f) {
  return py::make_tuple(f.t, tuple_of(f.pose.x), py::make_tuple(f.pose.r.w(), f.pose.r.x(), f.pose.r.y(), f.pose.r.z()),
                        tuple_of(f.force), f.f_n, f.f_t, tuple_of(f.normal), tuple_of(f.point), tuple_of(f.torque),
                        f.cone_ratio, static_cast<int>(f.mode), f.triangle, f.facet, f.toi, f.gap, f.residual,
                        f.model_frame, f.contacts, f.events, f.flags);
}

LocalFrame frame_of(const py::tuple& s) {
  constexpr std::size_t kFields = 20;
  if (s.size() != kFields) throw InputError("Frame: pickled by another version");
  LocalFrame f;
  std::size_t i = 0;
  const auto take = [&](auto& to) { to = s[i++].cast<std::decay_t<decltype(to)>>(); };
  const auto take_vector = [&](Vec3& to) { to = vector_of(s[i++]); };
  take(f.t);
  take_vector(f.pose.x);
  const auto turn = s[i++].cast<std::array<double, 4>>();
  f.pose.r = Quaternion(turn[0], turn[1], turn[2], turn[3]);
  take_vector(f.force);
  take(f.f_n);
  take(f.f_t);
  for (Vec3* v : {&f.normal, &f.point, &f.torque}) take_vector(*v);
  take(f.cone_ratio);
  f.mode = static_cast<ContactMode>(s[i++].cast<int>());
  take(f.triangle);
  take(f.facet);
  for (double* v : {&f.toi, &f.gap, &f.residual}) take(*v);
  for (int* v : {&f.model_frame, &f.contacts, &f.events}) take(*v);
  take(f.flags);
  return f;
}

}  // namespace

void bind_frame(py::module_& m) {
  const auto read = [](auto member, const char*) { return [member](const LocalFrame& f) { return f.*member; }; };
  py::class_<LocalFrame> frame(m, "Frame", "Result of one haptic tick for one tool. SI units, world frame.");
  const auto add = [&](const char* name, auto member, const char* doc) {
    frame.def_property_readonly(name, read(member, doc), doc);
  };
  add("t", &LocalFrame::t, "end of the tick [s]");
  add("force", &LocalFrame::force, "force on the tool (3,) [N]");
  add("torque", &LocalFrame::torque, "torque on the tool about its reference point (3,) [N m]");
  add("f_n", &LocalFrame::f_n, "normal part of the force [N]");
  add("f_t", &LocalFrame::f_t, "tangential part of the force [N]");
  add("normal", &LocalFrame::normal, "normal of the contact that carries most, from the body towards the tool (3,)");
  add("point", &LocalFrame::point, "place of that one on the tool (3,) [m]");
  add("gap", &LocalFrame::gap, "smallest gap of a held contact [m], inf where nothing is touched");
  add("triangle", &LocalFrame::triangle, "triangle of the body's surface, -1 for none");
  add("contacts", &LocalFrame::contacts, "number of places that touch");
  add("model_frame", &LocalFrame::model_frame, "count of the local model in use");
  frame.def_property_readonly(
      "x", [](const LocalFrame& f) { return f.pose.x; }, "the tool's reference point at t (3,) [m]");
  frame.def_property_readonly(
      "turn",
      [](const LocalFrame& f) { return Eigen::Vector4d(f.pose.r.w(), f.pose.r.x(), f.pose.r.y(), f.pose.r.z()); },
      "the tool's turn at t, a quaternion w x y z (4,)");
  frame.def_property_readonly(
      "mode", [](const LocalFrame& f) { return name_of(f.mode); }, "free, stick, slide or frictional_slide");
  frame.def_property_readonly("_flags", [](const LocalFrame& f) { return f.flags; });
  frame.def(py::pickle(&state_of, &frame_of));
  frame.def("__repr__", [](const LocalFrame& f) {
    return text("<kilotouch.Frame: t ", f.t, " s, normal ", f.f_n, " N, tangential ", f.f_t, " N, ", name_of(f.mode),
                ">");
  });
  py::dict flags;
  for (const auto& [name, value] :
       std::initializer_list<std::pair<const char*, unsigned>>{{"EVENTS_EXHAUSTED", kEventsExhausted},
                                                               {"LEFT_PATCH", kLeftPatch},
                                                               {"LOST_ANCHOR", kLostAnchor},
                                                               {"RIGID_CONTACT", kRigidContact},
                                                               {"NOT_FINITE", kNotFinite},
                                                               {"CONTACTS_EXHAUSTED", kContactsExhausted},
                                                               {"PUSHED_OUT", kPushedOut},
                                                               {"STALE_MODEL", kStaleModel},
                                                               {"BODY_FAILED", kBodyFailed},
                                                               {"NO_MODEL", kNoModel},
                                                               {"BAD_POSE", kBadPose},
                                                               {"LATE_TICK", kLateTick},
                                                               {"GATED", kGated},
                                                               {"SLEWED", kSlewed},
                                                               {"STALE_POSE", kStalePose},
                                                               {"ON_APRON", kOnApron},
                                                               {"UNREFINED", kUnrefined},
                                                               {"WORK_EXHAUSTED", kWorkExhausted}})
    flags[name] = value;
  m.attr("_flags") = flags;
  py::list modes;
  for (const ContactMode mode :
       {ContactMode::free, ContactMode::stick, ContactMode::slide, ContactMode::frictional_slide})
    modes.append(name_of(mode));
  m.attr("MODES") = py::tuple(modes);
}

}  // namespace kt
