// Queries about motion, and rays, on placed shapes, for tests and benchmarks; a World has its own
// on bodies.
#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings/arguments.hpp"
#include "collision/feature.hpp"
#include "collision/queries.hpp"
#include "collision/sweep.hpp"
#include "contact/kinematics.hpp"

namespace py = pybind11;

namespace rb {
namespace {

using Vec4 = Eigen::Vector4d;

// The arguments of a BallisticSweep.
struct Motion {
  Pose pose;
  Vec3 linear_velocity, acceleration, angular_velocity, center;

  BallisticSweep sweep() const {
    return {pose, center, linear_velocity, acceleration, angular_velocity};
  }
};

Motion make_motion(const Vec3& position, const Vec4& orientation, const Vec3& linear_velocity,
                   const Vec3& acceleration, const Vec3& angular_velocity, const Vec3& center) {
  using bindings::checked_vector;
  return {{checked_vector("position", position),
           bindings::checked_orientation("orientation", orientation)},
          checked_vector("linear_velocity", linear_velocity),
          checked_vector("acceleration", acceleration),
          checked_vector("angular_velocity", angular_velocity),
          checked_vector("center", center)};
}

py::tuple impact(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                 double t_max) {
  const ImpactSearch found = find_time_of_impact(a, motion_a.sweep(), b, motion_b.sweep(), t_max);
  return py::make_tuple(found.time, found.iterations, found.converged);
}

py::object ray(const Shape& shape, const Vec3& position, const Vec4& orientation,
               const Vec3& origin, const Vec3& direction) {
  const std::optional<RayHit> hit =
      ray_cast(shape, {position, bindings::checked_orientation("orientation", orientation)}, origin,
               direction);
  if (!hit) return py::none();
  return py::make_tuple(hit->distance, hit->point, hit->normal);
}

// Rows of `motion`: center, velocity, angular velocity, acceleration, angular acceleration.
BodyMotion body_motion(const Eigen::Matrix<double, 5, 3>& rows) {
  return {rows.row(0), rows.row(1), rows.row(2), rows.row(3), rows.row(4)};
}

py::tuple kinematics(const Shape& a, const Vec3& position_a, const Vec4& orientation_a,
                     const Eigen::Matrix<double, 5, 3>& motion_a, const Shape& b,
                     const Vec3& position_b, const Vec4& orientation_b,
                     const Eigen::Matrix<double, 5, 3>& motion_b, double margin, int index) {
  const Pose pose_a{position_a, bindings::checked_orientation("orientation_a", orientation_a)};
  const Pose pose_b{position_b, bindings::checked_orientation("orientation_b", orientation_b)};
  ContactPoints points;
  find_contacts(a, pose_a, b, pose_b, margin, points);
  const ContactPoint& p = points.at(index);
  const ContactKinematics k = contact_kinematics(
      p, contact_surface(a, pose_a, feature_of_a(p.feature), -p.normal), body_motion(motion_a),
      contact_surface(b, pose_b, feature_of_b(p.feature), p.normal), body_motion(motion_b));
  return py::make_tuple(k.d, k.d_dot, k.d_ddot, k.normal_rate);
}

}  // namespace

void define_motion_queries(py::module_& m) {
  const Vec3 zero = Vec3::Zero();
  const Vec4 identity(0.0, 0.0, 0.0, 1.0);
  py::class_<Motion>(
      m, "Motion",
      "A ballistic motion: `center` (body coordinates, m) flies on a parabola, the body "
      "turns about it at a constant world angular velocity (rad/s).")
      .def(py::init(&make_motion), py::arg("position") = zero, py::arg("orientation") = identity,
           py::arg("linear_velocity") = zero, py::arg("acceleration") = zero,
           py::arg("angular_velocity") = zero, py::arg("center") = zero)
      .def(
          "at",
          [](const Motion& self, double t) {
            const Pose pose = self.sweep().at(t);
            return py::make_tuple(pose.position, Vec4(pose.orientation.coeffs()));
          },
          py::arg("t"), "(position, orientation) at time t, s.");
  m.def("time_of_impact", &impact, py::arg("shape_a"), py::arg("motion_a"), py::arg("shape_b"),
        py::arg("motion_b"), py::arg("t_max"),
        "(time or None, distance queries spent, converged): the first contact in [0, t_max], s.");
  m.def("ray_cast", &ray, py::arg("shape"), py::arg("position"), py::arg("orientation"),
        py::arg("origin"), py::arg("direction"),
        "(distance, point, normal) of the nearest hit of the ray, or None.");
  m.def("contact_kinematics", &kinematics, py::arg("shape_a"), py::arg("position_a"),
        py::arg("orientation_a"), py::arg("motion_a"), py::arg("shape_b"), py::arg("position_b"),
        py::arg("orientation_b"), py::arg("motion_b"), py::arg("margin"), py::arg("index"),
        "(d, d_dot, d_ddot, normal_rate) of one contact of find_contacts; a motion has the rows "
        "center, velocity, angular velocity, acceleration, angular acceleration.");
}

}  // namespace rb
