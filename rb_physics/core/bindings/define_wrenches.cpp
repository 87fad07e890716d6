// Applied wrenches and impulses, by row.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings/arrays.hpp"
#include "bindings/body_state.hpp"
#include "world/world.hpp"

namespace rb {

using bindings::change_state;

// Holds a wrench in place of the one its source gave before; the order is that of the sources.
// The same wrench again only lasts longer: it wakes nobody.
void hold(Body& body, const AppliedWrench& a) {
  const auto held = std::find_if(body.wrenches.begin(), body.wrenches.end(),
                                 [&a](const AppliedWrench& x) { return x.source == a.source; });
  if (held != body.wrenches.end() && held->frame == a.frame && held->force == a.force &&
      held->torque == a.torque && held->at_center == a.at_center && held->point == a.point) {
    held->remaining = a.remaining;
    return;
  }
  body.wake();
  std::erase_if(body.wrenches, [&a](const AppliedWrench& x) { return x.source == a.source; });
  const auto at = std::find_if(body.wrenches.begin(), body.wrenches.end(),
                               [&a](const AppliedWrench& x) { return x.source > a.source; });
  body.wrenches.insert(at, a);
}

namespace {

// Wrenches (N, 6) at the centres of mass of many bodies, one source number for each.
void apply_wrenches(World& w, const std::vector<std::int32_t>& rows,
                    const std::vector<std::int32_t>& sources, const InputArray& wrenches,
                    bool body_frame, double duration) {
  const double* p = wrenches.data();
  for (std::size_t k = 0; k < rows.size(); ++k, p += 6) {
    AppliedWrench a;
    a.source = sources.at(k);
    a.frame = body_frame ? WrenchFrame::BODY : WrenchFrame::WORLD;
    a.force = Vec3(p[0], p[1], p[2]);
    a.torque = Vec3(p[3], p[4], p[5]);
    a.remaining = duration;
    hold(w.bodies.at(rows[k]), a);
  }
}

}  // namespace

void define_wrenches(py::class_<World>& world) {
  world
      .def("_apply_wrench",
           [](World& w, int i, int source, const InputArray& force, const InputArray& torque,
              const std::optional<InputArray>& point, bool body_frame, double duration) {
             Body& b = w.bodies.at(i);
             AppliedWrench a;
             a.source = source;
             a.frame = body_frame ? WrenchFrame::BODY : WrenchFrame::WORLD;
             a.force = to_vec3(force);
             a.torque = to_vec3(torque);
             a.at_center = !point.has_value();
             if (point)
               a.point = body_frame ? to_vec3(*point) : b.pose().apply_inverse(to_vec3(*point));
             a.remaining = duration;
             hold(b, a);
           })
      .def("_apply_wrenches", &apply_wrenches)
      .def(
          "_clear_wrenches",
          [](World& w, int i, int source) {
            const std::size_t ended = std::erase_if(
                w.bodies.at(i).wrenches,
                [source](const AppliedWrench& x) { return source < 0 || x.source == source; });
            if (ended > 0) w.bodies.at(i).wake();
          },
          py::arg("row"), py::arg("source") = -1)
      .def("_apply_impulse",
           [](World& w, int i, const InputArray& impulse, const std::optional<InputArray>& point) {
             change_state(w.bodies.at(i), "impulse", impulse, [&](Body& b) {
               const Vec3 j = to_vec3(impulse);
               b.wake();
               b.state.p += j;
               if (point && !b.inertia.inv_body.isZero(0.0))
                 b.state.L += (to_vec3(*point) - b.state.x).cross(j);
             });
             w.geometry_dirty = true;
           });
}

}  // namespace rb
