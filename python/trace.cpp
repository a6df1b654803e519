#include "python/trace.hpp"

#include "apps/outputs/run_summary.hpp"

namespace kt {
namespace {

/// Rows of a record as they lie there, without a copy: read-only, and the trace stays as long as they do.
/// @param first  of row 0
template <class T>
py::array_t<T> column(const py::object& trace, const T* first, std::size_t stride, std::size_t rows,
                      std::size_t width) {
  std::vector<std::size_t> shape{rows}, strides{stride};
  if (width > 1) shape.push_back(width), strides.push_back(sizeof(T));
  py::array_t<T> out(shape, strides, first, trace);
  py::detail::array_proxy(out.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return out;
}

template <class T, class Read>
py::array_t<T> of_frames(const py::object& self, std::size_t width, Read&& read) {
  const auto& trace = self.cast<const Trace&>();
  const Record<LocalFrame>& frames = trace.run->result.tools[trace.tool].frames;
  if (frames.empty())
    return py::array_t<T>(width > 1 ? std::vector<std::size_t>{0, width} : std::vector<std::size_t>{0});
  return column<T>(self, read(frames[0]), sizeof(LocalFrame), frames.size(), width);
}

py::list tools_of(const Trace& trace) {
  py::list out;
  for (std::size_t k = 0; k < trace.run->result.tools.size(); ++k) out.append(Trace{trace.run, k});
  return out;
}

}  // namespace

void bind_trace(py::module_& m) {
  py::class_<Trace> trace(m, "Trace",
                          "Records of a run's first tool, numpy columns, a row a tick, read-only. SI units.");
  const auto vector = [&](const char* name, auto read, const char* doc) {
    trace.def_property_readonly(
        name, [read](const py::object& self) { return of_frames<double>(self, 3, read); }, doc);
  };
  const auto number = [&](const char* name, auto read, const char* doc) {
    using T = std::remove_cvref_t<decltype(*read(LocalFrame{}))>;
    trace.def_property_readonly(
        name, [read](const py::object& self) { return of_frames<T>(self, 1, read); }, doc);
  };
  number(
      "t", [](const LocalFrame& f) { return &f.t; }, "end of the tick (n,) [s]");
  vector(
      "x", [](const LocalFrame& f) { return f.pose.x.data(); }, "the tool's reference point (n, 3) [m]");
  vector(
      "force", [](const LocalFrame& f) { return f.force.data(); },
      "force on the tool, as written to the device (n, 3) [N]");
  vector(
      "torque", [](const LocalFrame& f) { return f.torque.data(); }, "torque about the reference point (n, 3) [N m]");
  vector(
      "normal", [](const LocalFrame& f) { return f.normal.data(); }, "normal of the contact that carries most (n, 3)");
  vector(
      "point", [](const LocalFrame& f) { return f.point.data(); }, "place of that one on the tool (n, 3) [m]");
  number(
      "f_n", [](const LocalFrame& f) { return &f.f_n; }, "normal part of the force (n,) [N]");
  number(
      "f_t", [](const LocalFrame& f) { return &f.f_t; }, "tangential part of the force (n,) [N]");
  number(
      "gap", [](const LocalFrame& f) { return &f.gap; },
      "smallest gap of a held contact (n,) [m], inf where nothing is touched");
  number(
      "triangle", [](const LocalFrame& f) { return &f.triangle; }, "triangle of the body's surface, -1 for none (n,)");
  number(
      "contacts", [](const LocalFrame& f) { return &f.contacts; }, "number of places that touch (n,)");
  number(
      "flags", [](const LocalFrame& f) { return &f.flags; }, "bits of kilotouch.Flag (n,)");
  static_assert(sizeof(ContactMode) == sizeof(int));
  number(
      "mode", [](const LocalFrame& f) { return reinterpret_cast<const int*>(&f.mode); },
      "0 free, 1 stick, 2 slide, 3 frictional slide, with the names kilotouch.MODES (n,)");
  trace.def_property_readonly("tools", &tools_of, "A Trace of each tool of the run.")
      .def_property_readonly(
          "hash", [](const Trace& t) { return hash_text(t.run->result.hash); },
          "Hash of every tick's place, force, mode and triangle, as `kilotouch run` prints it.")
      .def_property_readonly(
          "warnings",
          [](const Trace& t) -> py::object {
            return py::module_::import("json").attr("loads")(t.run->summary)["warnings"];
          },
          "The findings of the run, a line each, those of the summary.")
      .def_property_readonly(
          "summary", [](const Trace& t) { return py::module_::import("json").attr("loads")(t.run->summary); },
          "The dict of summary.json.")
      .def("save", &save, py::arg("folder"),
           "Writes trace.csv, summary.json and so on, and session.json, which `kilotouch replay` repeats, unless the "
           "body was "
           "given by "
           "mesh= or model=.")
      .def("__len__", [](const Trace& t) { return t.run->result.tools[t.tool].frames.size(); })
      .def("__repr__", [](const Trace& t) {
        return text("<kilotouch.Trace: ", t.run->result.tools[t.tool].frames.size(), " ticks, hash ",
                    hash_text(t.run->result.hash), ">");
      });
}

}  // namespace kt
