#include "python/bindings.hpp"

#include "api/kilotouch.hpp"

PYBIND11_MODULE(_kilotouch, m) {
  m.doc() = "Touch on deformable bodies at a kilohertz, see kilotouch";
  m.attr("__version__") = KT_VERSION;
  static kt::py::handle input = kt::py::register_exception<kt::InputError>(m, "InputError", PyExc_ValueError);
  kt::py::register_exception<kt::RunError>(m, "RunError", PyExc_RuntimeError);
  kt::py::register_exception_translator([](std::exception_ptr e) {
    try {
      if (e) std::rethrow_exception(e);
    } catch (const kt::InputError& error) {
      const std::string_view words = error.what(), option = "--set ";
      const bool is_option = words.starts_with(option);  // Python's users have set a key of a scene
      PyErr_SetString(input.ptr(), error.what() + (is_option ? option.size() : 0));
    } catch (const std::bad_alloc&) {
      PyErr_SetString(PyExc_MemoryError, "more memory is needed than there is");
    } catch (const std::length_error&) {
      PyErr_SetString(PyExc_MemoryError, "more memory is needed than there is");
    } catch (const kt::py::cast_error&) {
      PyErr_SetString(input.ptr(), "a value of another type is needed: see help()");
    }
  });
  kt::bind_mesh(m);
  kt::bind_scene(m);
  kt::bind_model(m);
  kt::bind_frame(m);
  kt::bind_device(m);
  kt::bind_touch(m);
  kt::bind_session(m);
  kt::py::module_::import("atexit").attr("register")(kt::py::cpp_function([] {
    kt::begin_ending();
    kt::end_touches();
    kt::end_background();
  }));
}
