// numpy arrays from the core's vectors, and back with a clear error.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "math/types.hpp"

namespace rb {

namespace py = pybind11;

inline void put(double* p, const Vec3& v) {
  for (int i = 0; i < 3; ++i) p[i] = v[i];
}

inline py::array_t<double> to_array(const Vec3& v) {
  py::array_t<double> out(3);
  for (int i = 0; i < 3; ++i) out.mutable_data()[i] = v[i];
  return out;
}

inline py::array_t<double> to_array(const Quat& q) {
  py::array_t<double> out(4);
  for (int i = 0; i < 4; ++i) out.mutable_data()[i] = q.coeffs()[i];
  return out;
}

inline py::array_t<double> to_array(const Mat3& m) {
  py::array_t<double> out({3, 3});
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) out.mutable_at(r, c) = m(r, c);
  }
  return out;
}

// What a user might take for the state itself is handed out as a copy that can't be written to:
// numpy then says so, where a write would be lost.
template <class T>
py::array_t<T> read_only(py::array_t<T> a) {
  py::detail::array_proxy(a.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return a;
}

using InputArray = py::array_t<double, py::array::c_style | py::array::forcecast>;

inline Vec3 to_vec3(const InputArray& a) {
  if (a.size() != 3) throw py::value_error("expected 3 numbers, got " + std::to_string(a.size()));
  return Vec3(a.data()[0], a.data()[1], a.data()[2]);
}

inline Quat to_quat(const InputArray& a) {
  if (a.size() != 4)
    throw py::value_error("expected 4 numbers (x, y, z, w), got " + std::to_string(a.size()));
  return Quat(a.data()[3], a.data()[0], a.data()[1], a.data()[2]);
}

inline Mat3 to_mat3(const InputArray& a) {
  if (a.size() != 9)
    throw py::value_error("expected a 3 x 3 matrix, got " + std::to_string(a.size()) + " numbers");
  Mat3 m;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) m(r, c) = a.data()[3 * r + c];
  }
  return m;
}

}  // namespace rb
