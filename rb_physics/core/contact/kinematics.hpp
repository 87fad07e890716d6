// Kinematics of a contact (S10): the separation d, its speed and its acceleration.
//
// The notes, with N from B to A and P_A, P_B the points of the bodies (v + omega x r) that meet:
//   d   = N . (P_A - P_B)
//   d'  = N . (P_A' - P_B') + N' . (P_A - P_B)
//   d'' = N . (P_A'' - P_B'') + 2 N' . (P_A' - P_B') + N'' . (P_A - P_B)
// Where a curved surface touches, the point that is nearest wanders over it, which the notes'
// points, fixed to the bodies, don't. With W_X the tensor of the radii of curvature of surface X
// (m; the Hessian of its support function: 0 at a vertex, r (1 - N N^T) on a sphere, r u u^T on the
// side of a cylinder, u across it) that adds
//   - sum over X of (N' - omega_X x N)^T W_X (N' - omega_X x N)
// to d''. (d(t) is the maximum over n of the gap along n, and h(n, t) = n.c + h_0(R^T n) for each
// body; differentiate twice and use that the gap is stationary in n.)
//
// N' by owner (ContactPoint::normal_owner):
//   A, B     a face of that body: N' = omega x N, N'' = alpha x N + omega x (omega x N)
//   EDGES    N stays perpendicular to both edges: (N' - omega_X x N) . e_X = 0 for X = A, B
//   CENTERS  stationarity: (W_A + W_B + d) N' = (P_A' - P_B')_tangential + sum W_X (omega_X x N),
//   within
//            the directions that no straight edge or generator line e_X binds as above
// For the last two, P_A - P_B = d N and N''.N = -N'.N', so N''.(P_A - P_B) = -d N'.N'.
#pragma once

#include <cstdint>

#include "collision/contact_point.hpp"
#include "math/types.hpp"
#include "shape/shape.hpp"

namespace rb {

// What a rigid body does at this instant; world axes.
struct BodyMotion {
  Vec3 center = Vec3::Zero();                // m, centre of mass
  Vec3 velocity = Vec3::Zero();              // m/s
  Vec3 angular_velocity = Vec3::Zero();      // rad/s
  Vec3 acceleration = Vec3::Zero();          // m/s^2
  Vec3 angular_acceleration = Vec3::Zero();  // rad/s^2

  Vec3 point_velocity(const Vec3& p) const { return velocity + angular_velocity.cross(p - center); }
  Vec3 point_acceleration(const Vec3& p) const {
    const Vec3 r = p - center;
    return acceleration + angular_acceleration.cross(r) +
           angular_velocity.cross(angular_velocity.cross(r));
  }
};

// The surface of one body where it touches.
struct ContactSurface {
  Mat3 radii = Mat3::Zero();  // W, m, in the tangent plane
  Vec3 line = Vec3::Zero();   // unit, straight edge or generator line; zero: none
};

// From the shape, its placement, its half of the contact's feature id (feature_of_a or
// feature_of_b) and the normal out of this body (-N for A, N for B). Compounds: pass the part and
// its pose.
ContactSurface contact_surface(const Shape& shape, const Pose& pose, std::uint32_t feature,
                               const Vec3& outward);

struct ContactKinematics {
  double d = 0.0;                   // m
  double d_dot = 0.0;               // m/s
  double d_ddot = 0.0;              // m/s^2
  Vec3 normal_rate = Vec3::Zero();  // N', 1/s
};

// How the contact itself moves while the bodies do, and what the relative velocity of the material
// points gains from that motion alone (no forces): the centripetal terms of S10, as a vector.
struct ContactDrift {
  Vec3 point_rate;     // m/s, of the geometric contact point
  Vec3 normal_rate;    // 1/s
  Vec3 velocity_rate;  // m/s^2, world axes
};

ContactKinematics contact_kinematics(const ContactPoint& contact, const ContactSurface& surface_a,
                                     const BodyMotion& a, const ContactSurface& surface_b,
                                     const BodyMotion& b);

}  // namespace rb
