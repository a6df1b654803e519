#include "python/bindings.hpp"

#include "api/kilotouch.hpp"

PYBIND11_MODULE(_kilotouch, m) {
  m.doc() = "Touch on deformable bodies at a kilohertz: see kilotouch";
  m.attr("__version__") = KT_VERSION;
  kt::py::register_exception<kt::InputError>(m, "InputError", PyExc_ValueError);
  kt::py::register_exception<kt::RunError>(m, "RunError", PyExc_RuntimeError);
  kt::bind_mesh(m);
  kt::bind_scene(m);
  kt::bind_model(m);
  kt::bind_frame(m);
  kt::bind_device(m);
  kt::bind_touch(m);
  kt::bind_session(m);
}
