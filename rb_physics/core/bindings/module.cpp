// The module table of rb_physics._core: one define_* call per class, nothing else.
#include <pybind11/pybind11.h>

namespace py = pybind11;

namespace rb {
void define_math(py::module_& m);
void define_motion_queries(py::module_& m);
void define_shapes(py::module_& m);
void define_surfaces(py::module_& m);
void define_queries(py::module_& m);
void define_broad_phase(py::module_& m);
void define_solver(py::module_& m);
void define_contact_row(py::module_& m);
void define_settings(py::module_& m);
void define_world(py::module_& m);
void define_batch(py::module_& m);
}  // namespace rb

PYBIND11_MODULE(_core, m) {
  m.doc() = "C++ core of rb_physics";
  m.attr("compiler") = __VERSION__;
  rb::define_math(m);
  rb::define_shapes(m);
  rb::define_surfaces(m);
  rb::define_queries(m);
  rb::define_broad_phase(m);
  rb::define_solver(m);
  rb::define_contact_row(m);
  rb::define_settings(m);
  rb::define_world(m);
  rb::define_batch(m);
  rb::define_motion_queries(m);
}
