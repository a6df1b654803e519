#pragma once
// The Python package: what the C++ front door has, in numpy's words. Nothing is decided here.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <atomic>
#include <memory>

#include "core/base/finding.hpp"
#include "core/body/deformable_model.hpp"
#include "haptics/driver/device_slots.hpp"
#include "haptics/tick/local_frame.hpp"
#include "io/scene/scene.hpp"
#include "python/background.hpp"
#include "python/made_only.hpp"

namespace kt {

namespace py = pybind11;

/// A scene in Python: the values, and the file that messages name.
struct NamedScene {
  Scene scene;
  std::string name;
};

using Floats = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// numpy's array with numbers of another type; throws what Python raises, as MemoryError.
template <class Numbers>
Numbers numbers_in(const py::array& array) {
  PyObject* const raw = py::detail::npy_api::get().PyArray_FromAny_(
      array.ptr(), py::dtype::of<typename Numbers::value_type>().release().ptr(), 0, 0,
      static_cast<int>(py::detail::npy_api::NPY_ARRAY_ENSUREARRAY_) | py::array::c_style | py::array::forcecast,
      nullptr);
  if (!raw) throw py::error_already_set();
  return py::reinterpret_steal<Numbers>(raw);
}

/// Real numbers of whatever array Python gives; texts and complex numbers are none. Throws InputError: `what` and
/// `shape`.
Floats numbers_of(const py::handle& given, const char* what, const char* shape);

/// numpy's (3,) or (7,): place [m], and the turn as a quaternion w x y z, which is made a unit one. Throws InputError;
/// a number that is not finite passes: the engine says what it does then.
Pose pose_of(const py::handle& given);

/// The same of a device: finite, and within 1e6 m.
Pose device_pose_of(const py::handle& given);

/// A number, not a text. Throws InputError.
double number_of(const py::handle& given, const char* what);

/// As os.fspath.
std::string path_of(const py::object& path);

/// (n, 3), ours.
py::array_t<double> rows_of(const VectorX& x);

/// Of Python's kilotouch.Model: mesh, mass, fixed; force and tangent are called back. With the GIL.
std::unique_ptr<DeformableModel> model_of(const py::object& own);

/// What the two, mesh and model, leave open; throws InputError where both are given, or neither and no file.
void check_body_source(const NamedScene& scene, const py::object& mesh, const py::object& model);

/// A dict each, as in the summary: what, weight, where, value, limit, cures.
py::list dicts_of(const std::vector<Finding>& findings);

/// Three numbers, for pickle.
py::tuple tuple_of(const Vec3& v);
Vec3 vector_of(const py::handle& three);

void bind_mesh(py::module_& m);
void bind_scene(py::module_& m);
void bind_model(py::module_& m);
void bind_frame(py::module_& m);
void bind_touch(py::module_& m);
void bind_device(py::module_& m);
void bind_session(py::module_& m);

/// Poses from Python, forces back to it: device `pushed`. One session at a time ticks it.
struct PushedDevice {
  std::shared_ptr<DeviceSlots> slots = std::make_shared<DeviceSlots>();
  std::uint64_t count = 0;
  std::atomic<bool> in_use{false};
};

/// For atexit: bodies in threads of their own stop.
void end_touches();

}  // namespace kt

KT_MADE_ONLY(kt::Mesh);
KT_MADE_ONLY(kt::NamedScene);
KT_MADE_ONLY(kt::LocalFrame);
KT_MADE_ONLY(kt::PushedDevice);
