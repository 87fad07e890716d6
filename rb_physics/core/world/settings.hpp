// Everything a user may choose about the physics. Defaults are those of the Python face.
#pragma once

#include <cstdint>
#include <optional>

#include "body/material.hpp"
#include "math/tolerances.hpp"
#include "math/types.hpp"
#include "solver/impact_law.hpp"

namespace rb {

enum class Stepper : std::uint8_t { FIXED, EVENT };
enum class FreeMotion : std::uint8_t { EXACT, RK4 };

struct Settings {
  Vec3 gravity = Vec3(0.0, 0.0, -9.81);  // m/s^2
  double dt = 1e-3;                      // s
  Stepper stepper = Stepper::FIXED;
  ImpactLaw impact_law = ImpactLaw::SIMULTANEOUS;
  FreeMotion free_motion = FreeMotion::EXACT;
  int threads = 1;
  bool sleeping = false;
  double tolerance = 1e-13;  // relative natural-map residual asked of the contact solver
  std::int64_t max_work =
      0;                // bound on one solve, in visits of one contact (about 0.1 us); 0: none
  int max_events = 16;  // contact times and stick events an island may have in one step
  Combine friction_combine = Combine::GEOMETRIC_MEAN;
  Combine restitution_combine = Combine::MAX;
  // Islands with more contact points than this take the whole step in one solve, without contact
  // times.
  int max_event_contacts = 16;
  // m/s: a rebound slower than this counts as resting. Unset: the speed at which the next bounce
  // would fit into one step, acceleration * dt / 2 (the Zeno rule).
  std::optional<double> restitution_threshold;
  // m: contacts are looked for up to this separation beyond what the bodies can close in one step.
  double contact_margin = 0.0;
};

}  // namespace rb
