// The notes' generic solver on S6: one classical Runge-Kutta step of fourth order, q normalised
// (S5).
#pragma once

#include "body/state.hpp"

namespace rb {

// Force and torque are constant over the step; h in s.
RigidState rk4_step(const RigidState& s, const Inertia& i, const Wrench& w, double h);

}  // namespace rb
