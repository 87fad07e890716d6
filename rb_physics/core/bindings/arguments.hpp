// What bindings share about arguments: checking them, and the error a bad one raises.
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>

#include <cmath>
#include <optional>
#include <string>

#include "bindings/arrays.hpp"
#include "math/tolerances.hpp"
#include "math/types.hpp"

namespace rb::bindings {

// Raises rb_physics.SceneError: "[body BODY: ]FIELD is VALUE; it must be ALLOWED".
[[noreturn]] inline void refuse(const std::string& field, const pybind11::object& value,
                                const std::string& allowed, const std::string& body = "") {
  namespace py = pybind11;
  const py::object type = py::module_::import("rb_physics.errors").attr("SceneError");
  const py::object error = type.attr("about")(
      body.empty() ? py::object(py::none()) : py::object(py::str(body)), field, value, allowed);
  PyErr_SetObject(type.ptr(), error.ptr());
  throw py::error_already_set();
}

// Raises rb_physics.SceneError: "FIELD: REASON".
[[noreturn]] inline void refuse_because(const std::string& field, const std::string& reason) {
  namespace py = pybind11;
  const py::object type = py::module_::import("rb_physics.errors").attr("SceneError");
  const py::object error = type(field + ": " + reason, py::arg("field") = field);
  PyErr_SetObject(type.ptr(), error.ptr());
  throw py::error_already_set();
}

// The real numbers in `value` as C-ordered doubles; none for text, truth values, complex numbers,
// dates and ragged lists, which numpy would make numbers of.
std::optional<InputArray> real_numbers(const pybind11::handle& value);

// A finite number; anything else is refused with `allowed`. numpy scalars and 0-d arrays are
// numbers.
double number(const std::string& field, const pybind11::object& value, const std::string& allowed);

// Finite numbers of that shape, refused as "3 finite numbers" and the like.
Vec3 vector3(const std::string& field, const pybind11::object& value);
Eigen::Vector4d vector4(const std::string& field, const pybind11::object& value);
Mat3 matrix3(const std::string& field, const pybind11::object& value);

// True or False; what is merely true-like is refused.
bool flag(const std::string& field, const pybind11::object& value);

// A whole number from `least`; a float is none, however whole.
std::int64_t whole_number(const std::string& field, const pybind11::object& value,
                          std::int64_t least);

inline pybind11::object as_list(const Eigen::Ref<const Eigen::VectorXd>& values) {
  pybind11::list list;
  for (const double x : values) list.append(x);
  return list;
}

// Lengths outside this range (m) would overflow or vanish in products of a few of them.
inline constexpr double least_length = 1e-9;
inline constexpr double greatest_length = 1e9;

inline double checked_length(const std::string& field, double value) {
  if (!(value >= least_length && value <= greatest_length)) {
    refuse(field, pybind11::cast(value), "a length between 1e-9 and 1e9 m");
  }
  return value;
}

inline Vec3 checked_vector(const std::string& field, const Vec3& value) {
  if (!(value.cwiseAbs().maxCoeff() <= greatest_length)) {
    refuse(field, as_list(value), "three finite numbers of at most 1e9 (m)");
  }
  return value;
}

// A unit quaternion (x, y, z, w); one off by rounding is normalised, more is refused.
inline Quat checked_orientation(const std::string& field, const Eigen::Vector4d& xyzw) {
  const double length = xyzw.norm();
  if (!(std::abs(length - 1.0) <= tolerance::quaternion_norm)) {
    refuse(field, as_list(xyzw), "a unit quaternion (x, y, z, w)");
  }
  const Quat q(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
  return std::abs(length - 1.0) <= 4e-16 ? q : q.normalized();
}

}  // namespace rb::bindings
