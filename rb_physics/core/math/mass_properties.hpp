// Mass, centre of mass and inertia of a rigid body (S4), and how they move between frames.
#pragma once

#include "math/types.hpp"

namespace rb {

struct MassProperties {
  double mass = 0.0;                   // kg, > 0 for a dynamic body
  Vec3 center_of_mass = Vec3::Zero();  // m, in body coordinates
  Mat3 inertia = Mat3::Zero();         // kg m^2, body axes, about the centre of mass
};

// The same mass seen from a parent frame: `pose` places the part in the parent.
MassProperties transformed(const MassProperties& part, const Pose& pose);

// Union of disjoint parts (parallel axis theorem).
MassProperties combined(const MassProperties& a, const MassProperties& b);

// Same distribution scaled to another mass.
MassProperties scaled_to_mass(const MassProperties& m, double mass);

// Principal moments (ascending) and the rotation whose columns are the principal axes:
// inertia = axes * diag(moments) * axes^T. A diagonal inertia is its own answer: identity axes, the
// moments in the order given, no rounding.
struct PrincipalInertia {
  Vec3 moments;  // kg m^2
  Quat axes;     // principal frame -> body frame
};
PrincipalInertia principal_inertia(const Mat3& inertia);

// Relative amount by which the largest moment exceeds the sum of the others (0 when physical;
// equality is a legal lamina).
double triangle_violation(const Vec3& moments);

}  // namespace rb
