// Free motion (S2, S4, S6) without a discretisation error: constant force exactly, torque-free
// rotation to rounding. The angular velocity is never stepped: it follows from L, which torque-free
// motion keeps.
#pragma once

#include "body/state.hpp"

namespace rb {

// rad in one step. A body that turns farther has diverged: its attitude says nothing any more.
inline constexpr double greatest_turn = 1e4;

// Orientation after h seconds of torque-free rotation with constant angular momentum L (world
// axes). Taylor series of dl/dt = l x J_b^-1 l, dq/dt = q omega_b / 2 (l = R^T L), order chosen so
// that the first neglected term is below rounding; a sphere turns in closed form.
Quat rotate_free(const Quat& q, const Vec3& L, const Inertia& i, double h);

// One step under a constant force and torque: x and p exactly; rotation by symmetric splitting of
// the torque (half kick, free rotation, half kick), exact when the torque is zero.
RigidState move_free(const RigidState& s, const Inertia& i, const Wrench& w, double h);

// Linear and angular velocity at its end, m/s and rad/s; what turns like a sphere need not be
// turned for that.
Vec6 velocities_after(const RigidState& s, const Inertia& i, const Wrench& w, double h);

}  // namespace rb
