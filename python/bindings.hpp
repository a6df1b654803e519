#pragma once
// The Python package: what the C++ front door has, in numpy's words. Nothing is decided here.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>

#include "core/body/deformable_model.hpp"
#include "haptics/driver/device_slots.hpp"
#include "io/scene/scene.hpp"

namespace kt {

namespace py = pybind11;

/// A scene in Python: the values, and the file that messages name.
struct NamedScene {
  Scene scene;
  std::string name;
};

/// numpy's (3,) or (7,): place [m], and the turn as a quaternion w x y z. Throws InputError.
Pose pose_of(const py::array_t<double>& values);

/// (n, 3), ours.
py::array_t<double> rows_of(const VectorX& x);

/// Of Python's kilotouch.Model: mesh, mass, fixed; force and tangent are called back. With the GIL.
std::unique_ptr<DeformableModel> model_of(const py::object& own);

/// What the two, mesh and model, leave open; throws InputError where both are given, or neither and no file.
void check_body_source(const NamedScene& scene, const py::object& mesh, const py::object& model);

void bind_mesh(py::module_& m);
void bind_scene(py::module_& m);
void bind_model(py::module_& m);
void bind_frame(py::module_& m);
void bind_touch(py::module_& m);
void bind_device(py::module_& m);
void bind_session(py::module_& m);

/// Poses from Python, forces back to it: device `pushed`.
struct PushedDevice {
  std::shared_ptr<DeviceSlots> slots = std::make_shared<DeviceSlots>();
  std::uint64_t count = 0;
};

}  // namespace kt
