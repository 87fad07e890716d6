#include "bindings/arguments.hpp"

namespace rb::bindings {

namespace {

InputArray numbers_of_shape(const std::string& field, const py::object& value,
                            std::initializer_list<py::ssize_t> shape, const std::string& allowed) {
  const std::optional<InputArray> a = real_numbers(value);
  bool good = a && a->ndim() == static_cast<py::ssize_t>(shape.size()) &&
              std::equal(shape.begin(), shape.end(), a->shape());
  for (py::ssize_t i = 0; good && i < a->size(); ++i) good = std::isfinite(a->data()[i]);
  if (!good) refuse(field, value, allowed);
  return *a;
}

}  // namespace

std::optional<InputArray> real_numbers(const py::handle& value) {
  const py::array given = py::array::ensure(value);
  if (!given) return std::nullopt;
  const char kind = given.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u' && kind != 'O') return std::nullopt;
  const InputArray numbers = InputArray::ensure(given);
  if (!numbers) return std::nullopt;
  return numbers;
}

double number(const std::string& field, const py::object& value, const std::string& allowed) {
  if (PyFloat_CheckExact(value.ptr())) {
    const double x = PyFloat_AS_DOUBLE(value.ptr());
    if (!std::isfinite(x)) refuse(field, value, allowed);
    return x;
  }
  return *numbers_of_shape(field, value, {}, allowed).data();
}

Vec3 vector3(const std::string& field, const py::object& value) {
  return to_vec3(numbers_of_shape(field, value, {3}, "3 finite numbers"));
}

Eigen::Vector4d vector4(const std::string& field, const py::object& value) {
  const InputArray a = numbers_of_shape(field, value, {4}, "4 finite numbers (x y z w)");
  return Eigen::Map<const Eigen::Vector4d>(a.data());
}

Mat3 matrix3(const std::string& field, const py::object& value) {
  return to_mat3(numbers_of_shape(field, value, {3, 3}, "3 x 3 finite numbers"));
}

bool flag(const std::string& field, const py::object& value) {
  if (!PyBool_Check(value.ptr())) refuse(field, value, "True or False");
  return value.ptr() == Py_True;
}

std::int64_t whole_number(const std::string& field, const py::object& value, std::int64_t least) {
  if (!PyBool_Check(value.ptr()) && PyIndex_Check(value.ptr())) {
    int overflow = 0;
    const py::object index = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
    const std::int64_t n = index ? PyLong_AsLongLongAndOverflow(index.ptr(), &overflow) : least - 1;
    PyErr_Clear();
    if (overflow == 0 && n >= least) return n;
    if (overflow > 0) refuse(field, value, "a whole number of at most 9223372036854775807");
  }
  refuse(field, value, "a whole number ≥ " + std::to_string(least));
}

}  // namespace rb::bindings
