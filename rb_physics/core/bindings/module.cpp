// The module table of rb_physics._core: one define_* call per class, nothing else.
#include <pybind11/pybind11.h>

PYBIND11_MODULE(_core, m) { m.doc() = "C++ core of rb_physics"; }
