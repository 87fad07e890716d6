// rb_physics._core.World: the world by row numbers. The Python face (world.py) adds names and
// checks.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <utility>

#include "bindings/arguments.hpp"
#include "bindings/arrays.hpp"
#include "bindings/body_state.hpp"
#include "bindings/contact_row.hpp"
#include "contact/builder.hpp"
#include "math/rotation.hpp"
#include "world/step.hpp"
#include "world/world.hpp"

namespace rb {

using bindings::change_state;

void define_body_queries(py::class_<World>& world);
void define_wrenches(py::class_<World>& world);

namespace {

template <int width, class Fill>
py::array_t<double> per_body(const World& w, Fill fill) {
  py::array_t<double> out(
      {static_cast<py::ssize_t>(w.bodies.size()), static_cast<py::ssize_t>(width)});
  double* p = out.mutable_data();
  for (const Body& body : w.bodies) {
    fill(body, p);
    p += width;
  }
  return out;
}

[[noreturn]] void throw_diverged(const World& w, const Diverged& e) {
  const std::string name = e.info.body >= 0 ? w.bodies[e.info.body].name : std::string();
  const py::object type = py::module_::import("rb_physics.errors").attr("DivergedError");
  const py::object error =
      type("step " + std::to_string(e.info.step) + ": the state of body '" + name +
               "' stopped being finite, grew beyond 1e30 or turned by more than 1e4 rad; the world "
               "holds the last good state: look "
               "for huge forces, masses or speeds",
           py::arg("step") = e.info.step, py::arg("body") = name);
  PyErr_SetObject(type.ptr(), error.ptr());
  throw py::error_already_set();
}

// Between two steps, a few times a second: so that Ctrl-C ends a long run with the last step whole.
class Interrupt {
 public:
  void check() {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::milliseconds(200)) return;
    last_ = now;
    const py::gil_scoped_acquire hold;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

void step_many(World& w, const py::object& count) {
  const std::int64_t n = bindings::whole_number("n", count, 0);
  try {
    const py::gil_scoped_release release;
    if (n == 1) return step(w);
    Interrupt interrupt;
    for (std::int64_t k = 0; k < n; ++k) {
      step(w);
      interrupt.check();
    }
  } catch (const Diverged& e) {
    throw_diverged(w, e);
  }
}

py::tuple drain_pair_impulses(World& w) {
  const auto count = static_cast<py::ssize_t>(w.pair_impulses.size());
  py::array_t<std::int32_t> rows({count, py::ssize_t{2}});
  py::array_t<double> sums({count, py::ssize_t{9}});
  std::int32_t* row = rows.mutable_data();
  double* sum = sums.mutable_data();
  for (const PairImpulse& p : w.pair_impulses) {
    row[0] = p.body_a;
    row[1] = p.body_b;
    put(sum, p.impulse);
    put(sum + 3, p.moment_a);
    put(sum + 6, p.moment_b);
    row += 2;
    sum += 9;
  }
  w.pair_impulses.clear();
  return py::make_tuple(rows, sums);
}

std::int32_t add(World& w, const Shape& shape, const std::string& name, BodyType type,
                 const MassProperties& mass, const InputArray& position,
                 const InputArray& orientation, const InputArray& linear_velocity,
                 const InputArray& angular_velocity, const Material& material,
                 const CollisionFilter& filter, bool locked_rotation) {
  Body body;
  body.name = name;
  body.type = type;
  body.material = material;
  body.filter = filter;
  body.center_of_mass = mass.center_of_mass;
  Inertia& in = body.inertia;
  if (type == BodyType::DYNAMIC) {
    in.mass = mass.mass;
    in.inv_mass = 1.0 / mass.mass;
    if (!locked_rotation) {
      in.body = mass.inertia;
      in.inv_body = inverse_of_inertia(mass.inertia);
      in.isotropic = mass.inertia == Mat3(mass.inertia(0, 0) * Mat3::Identity());
    }
  }
  const Pose pose{to_vec3(position), normalized(to_quat(orientation))};
  change_state(body, "position", position, [&](Body& b) { b.set_pose(pose); });
  change_state(body, "linear_velocity", linear_velocity,
               [&](Body& b) { b.set_linear_velocity(to_vec3(linear_velocity)); });
  change_state(body, "angular_velocity", angular_velocity,
               [&](Body& b) { b.set_angular_velocity(to_vec3(angular_velocity)); });
  return add_body(w, std::move(body), shape);
}

}  // namespace

void define_world(py::module_& m) {
  py::class_<World> world(m, "World");
  define_body_queries(world);
  define_wrenches(world);
  world
      .def(py::init([](const Settings& s) {
             auto w = std::make_unique<World>();
             w->settings = s;
             return w;
           }),
           py::arg("settings"))
      .def("step", &step_many, py::arg("n") = 1,
           "Advances the world by n steps of dt, n ≥ 0. Ctrl-C ends it between two steps. Raises "
           "SceneError "
           "for another n, DivergedError when a state stops being finite.")
      .def("_add",
           [](World& w, const Shape& shape, const std::string& name, BodyType type, double mass,
              const InputArray& center_of_mass, const InputArray& inertia,
              const InputArray& position, const InputArray& orientation,
              const InputArray& linear_velocity, const InputArray& angular_velocity,
              const Material& material, const CollisionFilter& filter, bool locked) {
             return add(w, shape, name, type, {mass, to_vec3(center_of_mass), to_mat3(inertia)},
                        position, orientation, linear_velocity, angular_velocity, material, filter,
                        locked);
           })
      .def("_remove", &remove_body)
      .def_property_readonly(
          "_settings", [](World& w) -> Settings& { return w.settings; },
          py::return_value_policy::reference_internal)
      .def_property_readonly(
          "stats", [](const World& w) { return w.stats; },
          "Statistics of the last step (rb.Stats).")
      .def(
          "drain_worst",
          [](World& w) {
            const WorstOfSteps worst = std::exchange(w.worst, {});
            return py::make_tuple(worst.residual, worst.max_penetration, worst.contacts);
          },
          "(residual, max_penetration, contacts): the largest of each, as in `stats`, over the "
          "steps "
          "since the last call.")
      .def_property_readonly("time", &World::time, "s since the start or the last reset.")
      .def_property(
          "step_count", [](const World& w) { return w.step_count; },
          [](World& w, const py::object& n) {
            w.step_count = static_cast<std::uint64_t>(bindings::whole_number("step_count", n, 0));
          },
          "Steps made; time = step_count * dt.")
      .def_property_readonly(
          "state_hash", [](const World& w) { return state_hash(w); },
          "64-bit hash over everything that influences the future (int).")
      .def_property(
          "keep_hashes", [](const World& w) { return w.keep_hashes; },
          [](World& w, const py::object& on) { w.keep_hashes = bindings::flag("keep_hashes", on); },
          "Log the state hash of every step for `drain_hashes`.")
      .def(
          "drain_hashes",
          [](World& w) {
            py::array_t<std::uint64_t> out(static_cast<py::ssize_t>(w.hashes.size()));
            std::copy(w.hashes.begin(), w.hashes.end(), out.mutable_data());
            w.hashes.clear();
            return out;
          },
          "State hashes of the steps since the last call, (n,) uint64.")
      .def(
          "save",
          [](const World& w) {
            const std::vector<std::uint8_t> data = save(w);
            return py::bytes(reinterpret_cast<const char*>(data.data()), data.size());
          },
          "The full state as bytes, for `restore` on this or an equally built world.")
      .def(
          "restore",
          [](World& w, const py::bytes& data) {
            const std::string_view v = data;
            restore(w, reinterpret_cast<const std::uint8_t*>(v.data()), v.size());
          },
          py::arg("snapshot"),
          "Back to a saved state. Raises ValueError when it is of another world.")
      .def_property_readonly(
          "positions",
          [](const World& w) {
            return read_only(
                per_body<3>(w, [](const Body& b, double* p) { put(p, b.pose().position); }));
          },
          "(N, 3) m, origin of each body frame, world axes. A copy, not to be written to: set "
          "`body.position`.")
      .def_property_readonly(
          "com_positions",
          [](const World& w) {
            return read_only(per_body<3>(w, [](const Body& b, double* p) { put(p, b.state.x); }));
          },
          "(N, 3) m, centre of mass of each body. Not to be written to.")
      .def_property_readonly(
          "orientations",
          [](const World& w) {
            return read_only(per_body<4>(w, [](const Body& b, double* p) {
              for (int i = 0; i < 4; ++i) p[i] = b.state.q.coeffs()[i];
            }));
          },
          "(N, 4) unit quaternions x y z w, body to world. Not to be written to: set "
          "`body.orientation`.")
      .def_property_readonly(
          "linear_velocities",
          [](const World& w) {
            return read_only(
                per_body<3>(w, [](const Body& b, double* p) { put(p, b.linear_velocity()); }));
          },
          "(N, 3) m/s, of the centres of mass, world axes. Not to be written to: set "
          "`body.linear_velocity`.")
      .def_property_readonly(
          "angular_velocities",
          [](const World& w) {
            return read_only(
                per_body<3>(w, [](const Body& b, double* p) { put(p, b.angular_velocity()); }));
          },
          "(N, 3) rad/s, world axes. Not to be written to: set `body.angular_velocity`.")
      .def_property_readonly(
          "contact_wrenches",
          [](const World& w) {
            py::array_t<double> flat = per_body<6>(w, [&w](const Body& b, double* p) {
              put(p, b.contact_impulse / w.settings.dt);
              put(p + 3, b.contact_moment / w.settings.dt);
            });
            return flat.reshape(
                {static_cast<py::ssize_t>(w.bodies.size()), py::ssize_t{2}, py::ssize_t{3}});
          },
          "(N, 2, 3) contact force (N) and torque about the centre of mass (N m), world axes, mean "
          "over the last step.")
      .def(
          "drain_contact_impulses",
          [](World& w) {
            py::array_t<double> out = per_body<6>(w, [](const Body& b, double* p) {
              put(p, b.contact_impulse_sum);
              put(p + 3, b.contact_moment_sum);
            });
            for (Body& b : w.bodies) b.contact_impulse_sum = b.contact_moment_sum = Vec3::Zero();
            return out;
          },
          "(N, 6) contact impulse (N s) and angular impulse about the moving centre of mass (N m "
          "s), world axes, "
          "since the last call.")
      .def_property(
          "keep_pair_impulses", [](const World& w) { return w.keep_pair_impulses; },
          [](World& w, const py::object& on) {
            w.keep_pair_impulses = bindings::flag("keep_pair_impulses", on);
          },
          "Sum up what each pair of bodies does to each other for `drain_pair_impulses`.")
      .def("drain_pair_impulses", &drain_pair_impulses,
           "(rows (M, 2) int32 of bodies A and B, sums (M, 9)) since the last call, ordered by "
           "rows: "
           "impulse on A (N s), angular impulse on A and on B, each about its own moving centre of "
           "mass (N m s), world axes. Needs `keep_pair_impulses`.")
      .def_property_readonly("contacts", &contact_rows,
                             "Structured array, one row per contact point.")
      .def_property_readonly(
          "kinetic_energy",
          [](const World& w) {
            double e = 0.0;
            for (const Body& b : w.bodies) {
              if (b.is_dynamic()) e += kinetic_energy(b.state, b.inertia);
            }
            return e;
          },
          "J, of the dynamic bodies.")
      .def_property_readonly(
          "potential_energy",
          [](const World& w) {
            double e = 0.0;
            for (const Body& b : w.bodies) e -= b.inertia.mass * w.settings.gravity.dot(b.state.x);
            return e;
          },
          "J, -m g.x of the dynamic bodies.")
      .def_property_readonly(
          "linear_momentum",
          [](const World& w) {
            Vec3 p = Vec3::Zero();
            for (const Body& b : w.bodies) p += b.state.p;
            return to_array(p);
          },
          "(3,) kg m/s, of the dynamic bodies.")
      .def_property_readonly(
          "angular_momentum",
          [](const World& w) {
            Vec3 l = Vec3::Zero();
            for (const Body& b : w.bodies) l += b.state.x.cross(b.state.p) + b.state.L;
            return to_array(l);
          },
          "(3,) kg m^2/s, about the world origin, of the dynamic bodies.")
      .def("_position", [](const World& w,
                           int i) { return read_only(to_array(w.bodies.at(i).pose().position)); })
      .def("_com_position",
           [](const World& w, int i) { return read_only(to_array(w.bodies.at(i).state.x)); })
      .def("_orientation",
           [](const World& w, int i) { return read_only(to_array(w.bodies.at(i).state.q)); })
      .def("_linear_velocity",
           [](const World& w, int i) {
             return read_only(to_array(w.bodies.at(i).linear_velocity()));
           })
      .def("_angular_velocity",
           [](const World& w, int i) {
             return read_only(to_array(w.bodies.at(i).angular_velocity()));
           })
      .def("_contact_wrench",
           [](const World& w, int i) {
             py::array_t<double> out({2, 3});
             put(out.mutable_data(), w.bodies.at(i).contact_impulse / w.settings.dt);
             put(out.mutable_data() + 3, w.bodies.at(i).contact_moment / w.settings.dt);
             return out;
           })
      .def("_set_pose",
           [](World& w, int i, const InputArray& position, const InputArray& orientation) {
             const Pose pose{to_vec3(position), normalized(to_quat(orientation))};
             change_state(w.bodies.at(i), "position", position,
                          [&](Body& b) { bindings::set_pose(b, pose); });
             w.geometry_dirty = true;
           })
      .def("_set_linear_velocity",
           [](World& w, int i, const InputArray& v) {
             change_state(w.bodies.at(i), "linear_velocity", v,
                          [&](Body& b) { b.set_linear_velocity(to_vec3(v)); });
             w.geometry_dirty = true;
           })
      .def("_set_angular_velocity",
           [](World& w, int i, const InputArray& v) {
             change_state(w.bodies.at(i), "angular_velocity", v,
                          [&](Body& b) { b.set_angular_velocity(to_vec3(v)); });
             w.geometry_dirty = true;
           })
      .def("_set_target",
           [](World& w, int i, const InputArray& position, const InputArray& orientation,
              bool stop) {
             w.bodies.at(i).target = Pose{to_vec3(position), normalized(to_quat(orientation))};
             w.bodies.at(i).stop_after_target = stop;
             w.geometry_dirty = true;
           })
      .def("_set_material",
           [](World& w, int i, const Material& m) {
             w.bodies.at(i).material = m;
             w.bodies.at(i).wake();
             w.geometry_dirty = true;
           })
      .def("_asleep", [](const World& w, int i) { return w.bodies.at(i).asleep; })
      .def("_material", [](const World& w, int i) { return w.bodies.at(i).material; })
      .def("_filter", [](const World& w, int i) { return w.bodies.at(i).filter; })
      .def("_mass_properties",
           [](const World& w, int i) {
             const Body& b = w.bodies.at(i);
             return py::make_tuple(b.inertia.mass, read_only(to_array(b.center_of_mass)),
                                   read_only(to_array(b.inertia.body)));
           })
      .def("_detect", &detect_contacts);
}

}  // namespace rb
