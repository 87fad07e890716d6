// A persistent contact: one point of a manifold between two bodies, the force it carries from step
// to step (warm start), and its class (S9).
#pragma once

#include <cstdint>

#include "body/material.hpp"
#include "collision/contact_point.hpp"

namespace rb {

// The sign of N . V (S9). Values are part of the public interface (rb.ContactState).
enum class ContactState : std::uint8_t { COLLIDING = 0, RESTING = 1, SEPARATING = 2 };

// One tolerance for the whole package: |N . V| <= resting_speed (m/s) rests.
inline ContactState classify(double normal_speed, double resting_speed) {
  if (normal_speed < -resting_speed) return ContactState::COLLIDING;
  if (normal_speed > resting_speed) return ContactState::SEPARATING;
  return ContactState::RESTING;
}

// What part a contact takes in the step. Values are those of snapshots.
enum class ContactRole : std::uint8_t {
  ACTIVE = 0,
  GHOST = 1,    // carried an impulse in the step but is gone at its end: for the report only
  COVERED = 2,  // lies in the plane of a face the body stands on: never felt (world/seams.hpp)
};

struct Contact {
  std::int32_t body_a = -1;  // row; always dynamic
  std::int32_t body_b = -1;  // row; static and kinematic bodies are always B
  std::int32_t collider_a = -1;
  std::int32_t collider_b = -1;
  ContactRole role = ContactRole::ACTIVE;
  ContactState state = ContactState::RESTING;
  double touch = 0.0;           // m, separation up to which it counts as touching
  Material material;            // combined
  ContactPoint point;           // geometry at the end of the last step
  Vec3 local_a = Vec3::Zero();  // m, point on A in body coordinates: follows the body inside a step
  Vec3 local_b = Vec3::Zero();  // m, the same on B
  Vec3 warm_force = Vec3::Zero();   // N, contact frame (n, t1, t2): what it carried last
  Vec3 warm_moment = Vec3::Zero();  // N m, contact frame: spinning, rolling
  Vec3 impulse = Vec3::Zero();      // N s on A over the last step, world axes
  Vec3 moment_a = Vec3::Zero();  // N m s, angular impulse on A about its centre of mass, last step
  Vec3 moment_b = Vec3::Zero();  // N m s, the same on B
  bool loaded = false;           // carried force until now, by the last solve
  bool lifted = false;           // its geometry is that of a plane beside it (world/seams.cpp)
  bool stuck = false;            // its friction was within the cone, and no impact since

  // What carries force is closed, however far the third-order error of its turning has opened it.
  bool touching() const { return point.separation <= touch || has_opened(); }
  static constexpr double most_opened = 1e4;  // of the touch distance
  bool has_opened() const {
    return loaded && point.separation > touch && point.separation <= most_opened * touch;
  }
  // Friction strictly within (or, with a larger static coefficient, beyond) what sliding makes of a
  // force in the contact frame: the contact did not slide under it.
  bool sticks_under(const Vec3& force) const {
    constexpr double rounding = 1e-6;
    const double sliding = material.friction * force.x();
    const double share = force.tail<2>().squaredNorm();
    return share < (1.0 - rounding) * (sliding * sliding) ||
           share > (1.0 + rounding) * (sliding * sliding);
  }
  // Takes part in impacts, rest and position correction.
  bool active() const { return role == ContactRole::ACTIVE; }
};

}  // namespace rb
