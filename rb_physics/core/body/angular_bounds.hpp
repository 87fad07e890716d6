// How fast a free body can come to turn, whatever its attitude: for those who must not miss it.
#pragma once

#include "body/state.hpp"

namespace rb {

// rad/s, over the next t seconds under a constant torque of that size (N m).
//
// Two bounds, the lower one counts:
//   energy      |omega| <= sqrt(2 E / J_min),  sqrt(2 E) grows by at most t |tau| / sqrt(J_min)
//   Euler       |omega_i'| <= |omega_j omega_k| + |tau| / J_min,  because |J_j - J_k| <= J_i for
//               every real body; so |omega|' <= |omega|^2 / sqrt 3 + |tau| / J_min
// 1 / J_min is taken as the trace of J^-1, which is above it.
double max_angular_speed(const RigidState& state, const Inertia& inertia, double torque, double t);

// rad/s^2, while no faster than `speed` (rad/s).
double max_angular_acceleration(const Inertia& inertia, double torque, double speed);

}  // namespace rb
