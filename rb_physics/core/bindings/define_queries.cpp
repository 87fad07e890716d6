// The queries of collision/ on placed shapes, for tests and benchmarks; a World has its own on
// bodies.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <cstdint>

#include "bindings/arguments.hpp"
#include "collision/queries.hpp"
#include "math/mass_properties.hpp"

namespace py = pybind11;

namespace rb {

namespace {

using Poses = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Vec4 = Eigen::Vector4d;

Pose pose_of(const char* which, const Vec3& position, const Vec4& orientation) {
  return {bindings::checked_vector(std::string("position_") + which, position),
          bindings::checked_orientation(std::string("orientation_") + which, orientation)};
}

template <class Field>
py::array_t<double> vectors(const ContactPoints& points, Field field) {
  py::array_t<double> out({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}});
  auto view = out.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < view.shape(0); ++i) {
    const Vec3& v = points[i].*field;
    for (int k = 0; k < 3; ++k) view(i, k) = v[k];
  }
  return out;
}

template <class T, class Get>
py::array_t<T> column(const ContactPoints& points, Get get) {
  py::array_t<T> out(static_cast<py::ssize_t>(points.size()));
  auto view = out.template mutable_unchecked<1>();
  for (py::ssize_t i = 0; i < view.shape(0); ++i) view(i) = static_cast<T>(get(points[i]));
  return out;
}

py::dict contacts(const Shape& a, const Vec3& position_a, const Vec4& orientation_a, const Shape& b,
                  const Vec3& position_b, const Vec4& orientation_b, double margin) {
  ContactPoints points;
  find_contacts(a, pose_of("a", position_a, orientation_a), b,
                pose_of("b", position_b, orientation_b), margin, points);
  py::dict out;
  out["point_a"] = vectors(points, &ContactPoint::point_a);
  out["point_b"] = vectors(points, &ContactPoint::point_b);
  out["normal"] = vectors(points, &ContactPoint::normal);
  out["separation"] = column<double>(points, [](const ContactPoint& p) { return p.separation; });
  out["feature"] = column<std::int64_t>(points, [](const ContactPoint& p) { return p.feature; });
  out["kind"] = column<std::uint8_t>(points, [](const ContactPoint& p) { return p.kind; });
  out["normal_owner"] =
      column<std::uint8_t>(points, [](const ContactPoint& p) { return p.normal_owner; });
  return out;
}

py::tuple nearest(const Shape& a, const Vec3& position_a, const Vec4& orientation_a, const Shape& b,
                  const Vec3& position_b, const Vec4& orientation_b) {
  const DistanceResult r = distance(a, pose_of("a", position_a, orientation_a), b,
                                    pose_of("b", position_b, orientation_b));
  return py::make_tuple(r.distance, r.point_a, r.point_b, r.normal);
}

bool intersect(const Shape& a, const Vec3& position_a, const Vec4& orientation_a, const Shape& b,
               const Vec3& position_b, const Vec4& orientation_b) {
  return test_intersection(a, pose_of("a", position_a, orientation_a), b,
                           pose_of("b", position_b, orientation_b));
}

// Seconds for `repeats` passes of find_contacts over rows (position_a, orientation_a, position_b,
// orientation_b) of `poses`, and the contacts found in one pass.
py::tuple time_find_contacts(const Shape& a, const Shape& b, const Poses& poses, double margin,
                             int repeats) {
  if (poses.ndim() != 2 || poses.shape(1) != 14) {
    bindings::refuse("poses", poses, "an array of shape (n, 14)");
  }
  std::vector<std::pair<Pose, Pose>> placed;
  const auto view = poses.unchecked<2>();
  for (py::ssize_t i = 0; i < view.shape(0); ++i) {
    const auto pose = [&](int k) {
      return Pose{Vec3(view(i, k), view(i, k + 1), view(i, k + 2)),
                  Quat(view(i, k + 6), view(i, k + 3), view(i, k + 4), view(i, k + 5))};
    };
    placed.emplace_back(pose(0), pose(7));
  }
  ContactPoints points;
  std::size_t count = 0;
  double best = std::numeric_limits<double>::infinity();
  for (int r = 0; r < repeats; ++r) {
    count = 0;
    const auto start = std::chrono::steady_clock::now();
    for (const auto& [pose_a, pose_b] : placed) {
      points.clear();
      find_contacts(a, pose_a, b, pose_b, margin, points);
      count += points.size();
    }
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    best = std::min(best, taken.count());
  }
  return py::make_tuple(best, count);
}

py::tuple mass_tuple(const MassProperties& m) {
  return py::make_tuple(m.mass, m.center_of_mass, m.inertia);
}

}  // namespace

void define_queries(py::module_& m) {
  const auto pair = [&](const char* name, auto function, const char* doc, auto... more) {
    m.def(name, function, py::arg("shape_a"), py::arg("position_a"), py::arg("orientation_a"),
          py::arg("shape_b"), py::arg("position_b"), py::arg("orientation_b"), more..., doc);
  };
  pair(
      "find_contacts", &contacts,
      "Contact points with separation <= margin (m), as a dict of arrays: point_a, point_b, normal "
      "(n, 3), separation, feature, kind, normal_owner (n,).",
      py::arg("margin") = 0.0);
  pair("distance", &nearest,
       "(distance, point_a, point_b, normal) of two placed shapes; negative when overlapping.");
  pair("test_intersection", &intersect, "True when the two placed shapes share a point.");
  m.def(
      "time_find_contacts", &time_find_contacts, py::arg("shape_a"), py::arg("shape_b"),
      py::arg("poses"), py::arg("margin"), py::arg("repeats"),
      "(best seconds of a pass, contacts of a pass) of find_contacts over rows of poses (n, 14).");
  m.def("shape_name", &shape_name, py::arg("shape"), "The name scene files use.");
  m.def("characteristic_size", &characteristic_size, py::arg("shape"),
        "The length, m, that tolerances are relative to.");
  m.def("bounding_radius", &bounding_radius, py::arg("shape"), py::arg("center"),
        "Radius, m, of the smallest sphere about `center` that holds the shape.");
  m.def(
      "bounding_box",
      [](const Shape& shape, const Vec3& position, const Vec4& orientation) {
        const Aabb box = bounding_box(
            shape, {position, bindings::checked_orientation("orientation", orientation)});
        return py::make_tuple(box.lower, box.upper);
      },
      py::arg("shape"), py::arg("position"), py::arg("orientation"),
      "(lower, upper), m, world axes.");
  m.def(
      "unit_density_mass", [](const Shape& shape) { return mass_tuple(unit_density_mass(shape)); },
      py::arg("shape"), "(mass, centre of mass, inertia about it) at density 1 kg/m^3.");
  m.def(
      "principal_inertia",
      [](const Mat3& inertia) {
        const PrincipalInertia p = principal_inertia(inertia);
        return py::make_tuple(p.moments, p.axes.coeffs());
      },
      py::arg("inertia"), "(moments (3,), axes (x, y, z, w)): the principal frame of an inertia.");
}

}  // namespace rb
