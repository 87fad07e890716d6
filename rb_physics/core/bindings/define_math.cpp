// rb_physics._core.math: rows S3-S5 as functions.
#include <pybind11/pybind11.h>

#include "bindings/arrays.hpp"
#include "math/elementary.hpp"
#include "math/rotation.hpp"

namespace rb {

void define_math(py::module_& parent) {
  py::module_ m = parent.def_submodule("math", "Rotations, rows S3 to S5 of the notes.");
  m.def(
      "skew", [](const InputArray& u) { return to_array(skew(to_vec3(u))); }, py::arg("u"),
      "Matrix with skew(u) @ r == cross(u, r). u (3,), result (3, 3). S3.");
  m.def(
      "rotation_derivative",
      [](const InputArray& r, const InputArray& w) {
        return to_array(rotation_derivative(to_mat3(r), to_vec3(w)));
      },
      py::arg("rotation"), py::arg("angular_velocity"),
      "dR/dt = skew(omega) R, 1/s. rotation (3, 3), angular_velocity (3,) rad/s in world axes. "
      "S3.");
  m.def(
      "gram_schmidt", [](const InputArray& r) { return to_array(gram_schmidt(to_mat3(r))); },
      py::arg("rotation"),
      "Orthonormal columns from drifted ones, in order, the third by cross product. (3, 3). Raises "
      "ValueError "
      "when the first two columns are zero or parallel. S3.");
  m.def(
      "quaternion_derivative",
      [](const InputArray& q, const InputArray& w) {
        const Eigen::Vector4d d = quaternion_derivative(to_quat(q), to_vec3(w));
        py::array_t<double> out(4);
        for (int i = 0; i < 4; ++i) out.mutable_data()[i] = d[i];
        return out;
      },
      py::arg("orientation"), py::arg("angular_velocity"),
      "dq/dt = omega q / 2, 1/s. orientation (4,) x y z w, angular_velocity (3,) rad/s in world "
      "axes. S5.");
  m.def(
      "normalize", [](const InputArray& q) { return to_array(normalized(to_quat(q))); },
      py::arg("orientation"), "q / |q|. (4,) x y z w. S5.");
  m.def(
      "rotation_matrix", [](const InputArray& q) { return to_array(rotation_matrix(to_quat(q))); },
      py::arg("orientation"), "Rotation matrix (3, 3) of a unit quaternion (4,) x y z w.");
  m.def(
      "quaternion",
      [](const InputArray& r) { return to_array(quaternion_from_matrix(to_mat3(r))); },
      py::arg("rotation"), "Unit quaternion (4,) x y z w with w >= 0 of a rotation matrix (3, 3).");
  m.def(
      "quaternion_multiply",
      [](const InputArray& a, const InputArray& b) {
        return to_array(Quat(to_quat(a) * to_quat(b)));
      },
      py::arg("a"), py::arg("b"),
      "Hamilton product a b of quaternions (4,) x y z w: the rotation b, then a.");
  m.def(
      "quaternion_from_rotation_vector",
      [](const InputArray& v) { return to_array(quaternion_from_rotation_vector(to_vec3(v))); },
      py::arg("vector"), "Unit quaternion (4,) of a turn by |vector| rad about vector (3,).");
  m.def(
      "rotation_vector", [](const InputArray& q) { return to_array(rotation_vector(to_quat(q))); },
      py::arg("orientation"),
      "Axis times angle (3,), rad, at most pi long, of a unit quaternion (4,).");
  m.def(
      "rotate",
      [](const InputArray& q, const InputArray& v) {
        return to_array(Vec3(to_quat(q) * to_vec3(v)));
      },
      py::arg("orientation"), py::arg("vector"),
      "The vector (3,) turned by the unit quaternion (4,).");
  m.def(
      "contact_frame", [](const InputArray& n) { return to_array(contact_frame(to_vec3(n))); },
      py::arg("normal"), "Rows normal, t1, t2 (3, 3): the frame contact impulses are solved in.");
  m.def(
      "sin", [](double x) { return sin(x); }, py::arg("x"),
      "Sine with the same bits on every machine.");
  m.def(
      "cos", [](double x) { return cos(x); }, py::arg("x"),
      "Cosine with the same bits on every machine.");
  m.def(
      "atan2", [](double y, double x) { return atan2(y, x); }, py::arg("y"), py::arg("x"),
      "Angle of (x, y), rad, with the same bits on every machine.");
}

}  // namespace rb
