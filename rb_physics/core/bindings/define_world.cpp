// rb_physics._core.World: the world by row numbers. The Python face (world.py) adds names and
// checks.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings/arrays.hpp"
#include "bindings/contact_row.hpp"
#include "contact/builder.hpp"
#include "math/rotation.hpp"
#include "world/step.hpp"
#include "world/world.hpp"

namespace rb {

void define_body_queries(py::class_<World>& world);

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

void put(double* p, const Vec3& v) {
  for (int i = 0; i < 3; ++i) p[i] = v[i];
}

[[noreturn]] void throw_diverged(const World& w, const Diverged& e) {
  const std::string name = e.info.body >= 0 ? w.bodies[e.info.body].name : std::string();
  const py::object type = py::module_::import("rb_physics.errors").attr("DivergedError");
  const py::object error =
      type("step " + std::to_string(e.info.step) + ": the state of body '" + name +
               "' stopped being finite; the world holds the last good state: look for huge forces, "
               "masses or speeds",
           py::arg("step") = e.info.step, py::arg("body") = name);
  PyErr_SetObject(type.ptr(), error.ptr());
  throw py::error_already_set();
}

void step_many(World& w, std::uint64_t n) {
  try {
    const py::gil_scoped_release release;
    for (std::uint64_t k = 0; k < n; ++k) step(w);
  } catch (const Diverged& e) {
    throw_diverged(w, e);
  }
}

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
                 bool locked_rotation) {
  Body body;
  body.name = name;
  body.type = type;
  body.material = material;
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
  body.set_pose({to_vec3(position), normalized(to_quat(orientation))});
  body.set_linear_velocity(to_vec3(linear_velocity));
  body.set_angular_velocity(to_vec3(angular_velocity));
  return add_body(w, std::move(body), shape);
}

void define_enums(py::module_& m) {
  py::enum_<BodyType>(m, "BodyType")
      .value("STATIC", BodyType::STATIC)
      .value("DYNAMIC", BodyType::DYNAMIC)
      .value("KINEMATIC", BodyType::KINEMATIC);
  py::enum_<Stepper>(m, "Stepper").value("FIXED", Stepper::FIXED).value("EVENT", Stepper::EVENT);
  py::enum_<ImpactLaw>(m, "ImpactLaw")
      .value("SEQUENTIAL", ImpactLaw::SEQUENTIAL)
      .value("SIMULTANEOUS", ImpactLaw::SIMULTANEOUS)
      .value("REFLECTIONS", ImpactLaw::REFLECTIONS);
  py::enum_<FreeMotion>(m, "FreeMotion")
      .value("EXACT", FreeMotion::EXACT)
      .value("RK4", FreeMotion::RK4);
  py::enum_<Combine>(m, "Combine")
      .value("GEOMETRIC_MEAN", Combine::GEOMETRIC_MEAN)
      .value("MEAN", Combine::MEAN)
      .value("MIN", Combine::MIN)
      .value("MAX", Combine::MAX)
      .value("PRODUCT", Combine::PRODUCT);
}

void define_plain_data(py::module_& m) {
  py::class_<Material>(m, "Material")
      .def(py::init<>())
      .def_readwrite("friction", &Material::friction)
      .def_readwrite("static_friction", &Material::static_friction)
      .def_readwrite("rolling_friction", &Material::rolling_friction)
      .def_readwrite("spinning_friction", &Material::spinning_friction)
      .def_readwrite("restitution", &Material::restitution);
  py::class_<Settings>(m, "CoreSettings")
      .def(py::init<>())
      .def_property(
          "gravity", [](const Settings& s) { return to_array(s.gravity); },
          [](Settings& s, const InputArray& g) { s.gravity = to_vec3(g); })
      .def_readwrite("dt", &Settings::dt)
      .def_readwrite("stepper", &Settings::stepper)
      .def_readwrite("impact_law", &Settings::impact_law)
      .def_readwrite("free_motion", &Settings::free_motion)
      .def_readwrite("threads", &Settings::threads)
      .def_readwrite("sleeping", &Settings::sleeping)
      .def_readwrite("tolerance", &Settings::tolerance)
      .def_readwrite("max_work", &Settings::max_work)
      .def_readwrite("max_events", &Settings::max_events)
      .def_readwrite("max_event_contacts", &Settings::max_event_contacts)
      .def_readwrite("friction_combine", &Settings::friction_combine)
      .def_readwrite("restitution_combine", &Settings::restitution_combine)
      .def_readwrite("restitution_threshold", &Settings::restitution_threshold)
      .def_readwrite("contact_margin", &Settings::contact_margin);
  py::class_<Stats>(m, "Stats", "What the last step did.")
      .def_readonly("residual", &Stats::residual,
                    "Largest relative natural-map residual of its contact solves.")
      .def_readonly("iterations", &Stats::iterations, "Solver iterations, all islands.")
      .def_readonly("contacts", &Stats::contacts,
                    "Contact points that touch or carried an impulse.")
      .def_readonly("islands", &Stats::islands, "Groups of bodies connected by contacts.")
      .def_readonly("pairs", &Stats::pairs, "Broad-phase pairs.")
      .def_readonly("events", &Stats::events,
                    "Contact times and stick events found inside the step.")
      .def_readonly("impacts", &Stats::impacts, "Impact-law solves.")
      .def_readonly("corrections", &Stats::corrections,
                    "Position corrections; they change no velocity.")
      .def_readonly("capped", &Stats::capped, "Islands that met max_work or max_events.")
      .def_readonly("queries_capped", &Stats::queries_capped,
                    "Geometric queries whose iterations ran out: they answer less exactly.")
      .def_readonly("retries", &Stats::retries,
                    "Times the step was made again for a meeting nobody looked for.")
      .def_readonly("asleep", &Stats::asleep, "Dynamic bodies that sleep.")
      .def_readonly("max_penetration", &Stats::max_penetration, "m, at the end of the step.")
      .def_readonly("energy_error", &Stats::energy_error,
                    "Kinetic energy the contact solves gained, relative; 0 when none did.")
      .def_readonly("detect_time", &Stats::detect_time, "s of wall clock, broad and narrow phase.")
      .def_readonly("advance_time", &Stats::advance_time,
                    "s of wall clock, islands: impacts, contact solves, contact times, motion.")
      .def_readonly("correct_time", &Stats::correct_time, "s of wall clock, overlap taken out.")
      .def_readonly("step_time", &Stats::step_time, "s of wall clock, the whole step.");
}

}  // namespace

void define_world(py::module_& m) {
  define_enums(m);
  define_plain_data(m);
  py::class_<World> world(m, "World");
  define_body_queries(world);
  world
      .def(py::init([](const Settings& s) {
             auto w = std::make_unique<World>();
             w->settings = s;
             return w;
           }),
           py::arg("settings"))
      .def("step", &step_many, py::arg("n") = 1, "Advances the world by n steps of dt.")
      .def("_add",
           [](World& w, const Shape& shape, const std::string& name, BodyType type, double mass,
              const InputArray& center_of_mass, const InputArray& inertia,
              const InputArray& position, const InputArray& orientation,
              const InputArray& linear_velocity, const InputArray& angular_velocity,
              const Material& material, bool locked) {
             return add(w, shape, name, type, {mass, to_vec3(center_of_mass), to_mat3(inertia)},
                        position, orientation, linear_velocity, angular_velocity, material, locked);
           })
      .def("_remove", &remove_body)
      .def_property_readonly(
          "_settings", [](World& w) -> Settings& { return w.settings; },
          py::return_value_policy::reference_internal)
      .def_property_readonly(
          "stats", [](const World& w) { return w.stats; },
          "Statistics of the last step (rb.Stats).")
      .def_property_readonly("time", &World::time, "s since the start or the last reset.")
      .def_property(
          "step_count", [](const World& w) { return w.step_count; },
          [](World& w, std::uint64_t n) { w.step_count = n; },
          "Steps made; time = step_count * dt.")
      .def_property_readonly(
          "state_hash", [](const World& w) { return state_hash(w); },
          "64-bit hash over everything that influences the future (int).")
      .def_property(
          "keep_hashes", [](const World& w) { return w.keep_hashes; },
          [](World& w, bool on) { w.keep_hashes = on; },
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
            return per_body<3>(w, [](const Body& b, double* p) { put(p, b.pose().position); });
          },
          "(N, 3) m, origin of each body frame, world axes.")
      .def_property_readonly(
          "com_positions",
          [](const World& w) {
            return per_body<3>(w, [](const Body& b, double* p) { put(p, b.state.x); });
          },
          "(N, 3) m, centre of mass of each body.")
      .def_property_readonly(
          "orientations",
          [](const World& w) {
            return per_body<4>(w, [](const Body& b, double* p) {
              for (int i = 0; i < 4; ++i) p[i] = b.state.q.coeffs()[i];
            });
          },
          "(N, 4) unit quaternions x y z w, body to world.")
      .def_property_readonly(
          "linear_velocities",
          [](const World& w) {
            return per_body<3>(w, [](const Body& b, double* p) { put(p, b.linear_velocity()); });
          },
          "(N, 3) m/s, of the centres of mass, world axes.")
      .def_property_readonly(
          "angular_velocities",
          [](const World& w) {
            return per_body<3>(w, [](const Body& b, double* p) { put(p, b.angular_velocity()); });
          },
          "(N, 3) rad/s, world axes.")
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
          [](World& w, bool on) { w.keep_pair_impulses = on; },
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
      .def("_position",
           [](const World& w, int i) { return to_array(w.bodies.at(i).pose().position); })
      .def("_com_position", [](const World& w, int i) { return to_array(w.bodies.at(i).state.x); })
      .def("_orientation", [](const World& w, int i) { return to_array(w.bodies.at(i).state.q); })
      .def("_linear_velocity",
           [](const World& w, int i) { return to_array(w.bodies.at(i).linear_velocity()); })
      .def("_angular_velocity",
           [](const World& w, int i) { return to_array(w.bodies.at(i).angular_velocity()); })
      .def("_contact_wrench",
           [](const World& w, int i) {
             py::array_t<double> out({2, 3});
             put(out.mutable_data(), w.bodies.at(i).contact_impulse / w.settings.dt);
             put(out.mutable_data() + 3, w.bodies.at(i).contact_moment / w.settings.dt);
             return out;
           })
      .def("_set_pose",
           [](World& w, int i, const InputArray& position, const InputArray& orientation) {
             Body& b = w.bodies.at(i);
             const Vec3 v = b.linear_velocity();
             const Vec3 omega = b.angular_velocity();
             b.set_pose({to_vec3(position), normalized(to_quat(orientation))});
             b.set_linear_velocity(v);
             b.set_angular_velocity(omega);
             w.geometry_dirty = true;
           })
      .def("_set_linear_velocity",
           [](World& w, int i, const InputArray& v) {
             w.bodies.at(i).set_linear_velocity(to_vec3(v));
             w.geometry_dirty = true;
           })
      .def("_set_angular_velocity",
           [](World& w, int i, const InputArray& v) {
             w.bodies.at(i).set_angular_velocity(to_vec3(v));
             w.geometry_dirty = true;
           })
      .def("_set_target",
           [](World& w, int i, const InputArray& position, const InputArray& orientation,
              bool stop) {
             w.bodies.at(i).target = Pose{to_vec3(position), normalized(to_quat(orientation))};
             w.bodies.at(i).stop_after_target = stop;
             w.geometry_dirty = true;
           })
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
             Body& b = w.bodies.at(i);
             const Vec3 j = to_vec3(impulse);
             b.wake();
             b.state.p += j;
             if (point && !b.inertia.inv_body.isZero(0.0))
               b.state.L += (to_vec3(*point) - b.state.x).cross(j);
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
      .def("_mass_properties",
           [](const World& w, int i) {
             const Body& b = w.bodies.at(i);
             return py::make_tuple(b.inertia.mass, to_array(b.center_of_mass),
                                   to_array(b.inertia.body));
           })
      .def("_detect", &detect_contacts);
}

}  // namespace rb
