// Enums, material, settings and statistics: the plain data of a world.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings/arrays.hpp"
#include "world/settings.hpp"
#include "world/stats.hpp"
#include "world/world.hpp"

namespace rb {
namespace {

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
  py::class_<CollisionFilter>(m, "CollisionFilter")
      .def(py::init<std::uint32_t, std::uint32_t>(), py::arg("layer") = 1u,
           py::arg("mask") = 0xffffffffu)
      .def_readonly("layer", &CollisionFilter::layer)
      .def_readonly("mask", &CollisionFilter::mask);
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
      .def_readonly(
          "waits", &Stats::waits,
          "Of these, islands whose fast bodies wait out the rest of the step at a contact "
          "rather than pass through.")
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

void define_settings(py::module_& m) {
  define_enums(m);
  define_plain_data(m);
}

}  // namespace rb
