// Queries between the bodies of a world, by row (S7, S10).
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings/arrays.hpp"
#include "bindings/contact_row.hpp"
#include "world/body_queries.hpp"
#include "world/contact_rates.hpp"

namespace rb {
namespace {

// What of a contact needs no motion.
struct FoundRow {
  std::int32_t body_a;
  std::int32_t body_b;
  double point[3];
  double normal[3];
  double separation;
  std::int64_t feature;
  std::uint8_t kind;
};

py::array_t<FoundRow> found_rows(const World& w, std::int32_t a, std::int32_t b, double margin) {
  const ContactPoints points = find_contacts(w, a, b, margin);
  py::array_t<FoundRow> out(static_cast<py::ssize_t>(points.size()));
  FoundRow* row = out.mutable_data();
  for (const ContactPoint& p : points) {
    *row = {};
    row->body_a = a;
    row->body_b = b;
    const Vec3 point = 0.5 * (p.point_a + p.point_b);
    for (int k = 0; k < 3; ++k) {
      row->point[k] = point[k];
      row->normal[k] = p.normal[k];
    }
    row->separation = p.separation;
    row->feature = p.feature;
    row->kind = static_cast<std::uint8_t>(p.kind);
    ++row;
  }
  return out;
}

}  // namespace

void define_body_queries(py::class_<World>& world) {
  PYBIND11_NUMPY_DTYPE(FoundRow, body_a, body_b, point, normal, separation, feature, kind);
  world
      .def("_test_intersection", [](const World& w, std::int32_t a,
                                    std::int32_t b) { return test_intersection(w, a, b); })
      .def("_find_contacts", &found_rows)
      .def("_distance",
           [](const World& w, std::int32_t a, std::int32_t b) {
             const DistanceResult d = distance(w, a, b);
             return py::make_tuple(d.distance, to_array(d.point_a), to_array(d.point_b),
                                   to_array(d.normal));
           })
      .def("_time_of_impact",
           [](const World& w, std::int32_t a, std::int32_t b, double t_max) {
             const ImpactSearch found = time_of_impact(w, a, b, t_max);
             return py::make_tuple(found.time, found.converged);
           })
      .def("_ray_cast",
           [](const World& w, const InputArray& origin, const InputArray& direction) -> py::object {
             const auto hit = ray_cast(w, to_vec3(origin), to_vec3(direction));
             if (!hit) return py::none();
             return py::make_tuple(hit->body, hit->hit.distance, to_array(hit->hit.point),
                                   to_array(hit->hit.normal));
           })
      .def("_contact_kinematics", [](const World& w, int i) {
        const ContactKinematics k = contact_rates(w, w.contacts.at(shown_contacts(w).at(i)));
        return py::make_tuple(k.d, k.d_dot, k.d_ddot);
      });
}

}  // namespace rb
