// The notes' state vector (S6): S = [x, q, p, L] for one body, dS/dt = [p/m, omega q / 2, F, tau].
// Momenta are kept, velocities derived: p and L are conserved to rounding (S2, S4).
#pragma once

#include "math/types.hpp"

namespace rb {

struct RigidState {
  Vec3 x = Vec3::Zero();      // m, centre of mass, world
  Quat q = Quat::Identity();  // body axes -> world
  Vec3 p = Vec3::Zero();      // kg m/s, linear momentum, world axes
  Vec3 L = Vec3::Zero();      // kg m^2/s, angular momentum about the centre of mass, world axes
};

// What turns momenta into velocities. Zero inverses: the motion is locked (S1: a particle does not
// spin).
struct Inertia {
  double mass = 0.0;             // kg
  double inv_mass = 0.0;         // 1/kg
  Mat3 body = Mat3::Zero();      // J_b, kg m^2, body axes, about the centre of mass
  Mat3 inv_body = Mat3::Zero();  // J_b^-1
  bool isotropic = true;         // J_b is a multiple of the identity (or locked)
};

struct Wrench {
  Vec3 force = Vec3::Zero();   // N, world axes
  Vec3 torque = Vec3::Zero();  // N m, world axes, about the centre of mass
};

struct StateDerivative {
  Vec3 x;             // m/s
  Eigen::Vector4d q;  // 1/s, (x, y, z, w)
  Vec3 p;             // N
  Vec3 L;             // N m
};

// v = p / m (S2).
inline Vec3 linear_velocity(const RigidState& s, const Inertia& i) { return i.inv_mass * s.p; }

// Inverse of a symmetric positive definite inertia; exact reciprocals when it is diagonal.
Mat3 inverse_of_inertia(const Mat3& inertia);

// J^-1 = R J_b^-1 R^T in world axes (S4).
Mat3 world_inverse_inertia(const Quat& q, const Inertia& i);

// omega = J^-1 L (S4).
Vec3 angular_velocity_in_turn(const RigidState& s, const Inertia& i);  // by way of the body's axes
inline Vec3 angular_velocity(const RigidState& s, const Inertia& i) {
  if (i.isotropic) return i.inv_body(0, 0) * s.L;
  return angular_velocity_in_turn(s, i);
}

// L = R J_b R^T omega (S4).
Vec3 angular_momentum(const Quat& q, const Inertia& i, const Vec3& omega);

// dS/dt (S6).
StateDerivative derivative(const RigidState& s, const Inertia& i, const Wrench& w);

double kinetic_energy(const RigidState& s, const Inertia& i);  // J, p^2/2m + L.omega/2

}  // namespace rb
