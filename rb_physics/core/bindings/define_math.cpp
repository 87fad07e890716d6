// rb_physics._core.math: rows S3-S5 as functions. Bad arguments raise SceneError.
#include <pybind11/pybind11.h>

#include "bindings/arguments.hpp"
#include "bindings/arrays.hpp"
#include "math/elementary.hpp"
#include "math/rotation.hpp"

namespace rb {
namespace {

using bindings::matrix3;
using bindings::refuse;
using bindings::vector3;

// Any quaternion but zero, scaled so that its squares neither overflow nor vanish.
Quat quaternion_argument(const std::string& field, const py::object& value) {
  Eigen::Vector4d q = bindings::vector4(field, value);
  const double greatest = q.cwiseAbs().maxCoeff();
  if (greatest == 0.0) refuse(field, value, "a quaternion x y z w of length > 0");
  if (greatest > 1e100 || greatest < 1e-100) q /= greatest;
  return Quat(q[3], q[0], q[1], q[2]);
}

// A rotation: the bits stay, a length off by more than rounding and drift is refused.
Quat unit_quaternion(const std::string& field, const py::object& value) {
  const Eigen::Vector4d q = bindings::vector4(field, value);
  if (!(std::abs(q.norm() - 1.0) <= tolerance::quaternion_norm))
    refuse(field, value, "a unit quaternion x y z w (`normalize` makes one)");
  return Quat(q[3], q[0], q[1], q[2]);
}

Mat3 rotation_argument(const std::string& field, const py::object& value) {
  const Mat3 r = matrix3(field, value);
  if (!((r.transpose() * r - Mat3::Identity()).cwiseAbs().maxCoeff() <=
            tolerance::quaternion_norm &&
        r.determinant() > 0.0)) {
    refuse(field, value,
           "a rotation matrix: orthonormal columns, determinant 1 (`gram_schmidt` mends drift)");
  }
  return r;
}

Mat3 orthonormal(const py::object& value) {
  const Mat3 r = matrix3("rotation", value);
  try {
    return gram_schmidt(r);
  } catch (const std::invalid_argument& error) {
    bindings::refuse_because("rotation", error.what());
  }
}

// Beyond it an angle has less than a thousandth of a radian left.
constexpr double greatest_angle = 1e12;

double angle_argument(const py::object& value) {
  const std::string allowed = "a finite number of at most 1e12 (rad)";
  const double x = bindings::number("x", value, allowed);
  if (std::abs(x) > greatest_angle) refuse("x", value, allowed);
  return x;
}

}  // namespace

void define_math(py::module_& parent) {
  py::module_ m = parent.def_submodule("math", "Rotations, rows S3 to S5 of the notes.");
  m.def(
      "skew", [](const py::object& u) { return to_array(skew(vector3("u", u))); }, py::arg("u"),
      "Matrix with skew(u) @ r == cross(u, r). u (3,), result (3, 3). S3.");
  m.def(
      "rotation_derivative",
      [](const py::object& r, const py::object& w) {
        return to_array(
            rotation_derivative(matrix3("rotation", r), vector3("angular_velocity", w)));
      },
      py::arg("rotation"), py::arg("angular_velocity"),
      "dR/dt = skew(omega) R, 1/s. rotation (3, 3), angular_velocity (3,) rad/s in world axes. "
      "S3.");
  m.def(
      "gram_schmidt", [](const py::object& r) { return to_array(orthonormal(r)); },
      py::arg("rotation"),
      "Orthonormal columns from drifted ones, in order, the third by cross product. (3, 3). Raises "
      "SceneError when the first two columns are zero or parallel. S3.");
  m.def(
      "quaternion_derivative",
      [](const py::object& q, const py::object& w) {
        const Eigen::Vector4d d = quaternion_derivative(quaternion_argument("orientation", q),
                                                        vector3("angular_velocity", w));
        py::array_t<double> out(4);
        for (int i = 0; i < 4; ++i) out.mutable_data()[i] = d[i];
        return out;
      },
      py::arg("orientation"), py::arg("angular_velocity"),
      "dq/dt = omega q / 2, 1/s. orientation (4,) x y z w, angular_velocity (3,) rad/s in world "
      "axes. S5.");
  m.def(
      "normalize",
      [](const py::object& q) {
        return to_array(normalized(quaternion_argument("orientation", q)));
      },
      py::arg("orientation"), "q / |q|. (4,) x y z w, not zero. S5.");
  m.def(
      "rotation_matrix",
      [](const py::object& q) {
        return to_array(rotation_matrix(unit_quaternion("orientation", q)));
      },
      py::arg("orientation"), "Rotation matrix (3, 3) of a unit quaternion (4,) x y z w.");
  m.def(
      "quaternion",
      [](const py::object& r) {
        return to_array(quaternion_from_matrix(rotation_argument("rotation", r)));
      },
      py::arg("rotation"), "Unit quaternion (4,) x y z w with w >= 0 of a rotation matrix (3, 3).");
  m.def(
      "quaternion_multiply",
      [](const py::object& a, const py::object& b) {
        const Eigen::Vector4d x = bindings::vector4("a", a);
        const Eigen::Vector4d y = bindings::vector4("b", b);
        return to_array(Quat(Quat(x[3], x[0], x[1], x[2]) * Quat(y[3], y[0], y[1], y[2])));
      },
      py::arg("a"), py::arg("b"),
      "Hamilton product a b of quaternions (4,) x y z w: the rotation b, then a.");
  m.def(
      "quaternion_from_rotation_vector",
      [](const py::object& value) {
        const Vec3 v = vector3("vector", value);
        if (v.cwiseAbs().maxCoeff() > greatest_angle)
          refuse("vector", value, "3 finite numbers of at most 1e12 (rad)");
        return to_array(quaternion_from_rotation_vector(v));
      },
      py::arg("vector"), "Unit quaternion (4,) of a turn by |vector| rad about vector (3,).");
  m.def(
      "rotation_vector",
      [](const py::object& q) {
        return to_array(rotation_vector(unit_quaternion("orientation", q)));
      },
      py::arg("orientation"),
      "Axis times angle (3,), rad, at most pi long, of a unit quaternion (4,).");
  m.def(
      "rotate",
      [](const py::object& q, const py::object& v) {
        return to_array(Vec3(unit_quaternion("orientation", q) * vector3("vector", v)));
      },
      py::arg("orientation"), py::arg("vector"),
      "The vector (3,) turned by the unit quaternion (4,).");
  m.def(
      "contact_frame",
      [](const py::object& value) {
        const Vec3 n = vector3("normal", value);
        if (!(std::abs(n.norm() - 1.0) <= tolerance::quaternion_norm))
          refuse("normal", value, "a unit vector");
        return to_array(contact_frame(n));
      },
      py::arg("normal"),
      "Rows normal (unit), t1, t2 (3, 3): the frame contact impulses are solved in.");
  m.def(
      "sin", [](const py::object& x) { return sin(angle_argument(x)); }, py::arg("x"),
      "Sine with the same bits on every machine.");
  m.def(
      "cos", [](const py::object& x) { return cos(angle_argument(x)); }, py::arg("x"),
      "Cosine with the same bits on every machine.");
  m.def(
      "atan2",
      [](const py::object& y, const py::object& x) {
        return atan2(bindings::number("y", y, "a finite number"),
                     bindings::number("x", x, "a finite number"));
      },
      py::arg("y"), py::arg("x"), "Angle of (x, y), rad, with the same bits on every machine.");
}

}  // namespace rb
