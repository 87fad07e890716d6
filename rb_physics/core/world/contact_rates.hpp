// The kinematics of a contact (S10) of a world: how its separation, point and normal move.
#pragma once

#include "contact/kinematics.hpp"
#include "world/world.hpp"

namespace rb {

// d, d', d'' from the present state, gravity, applied wrenches and the contact forces of the last
// step.
ContactKinematics contact_rates(const World& world, const Contact& contact);

// How the contact itself moves while the bodies do, and what the relative velocity of the material
// points gains from that motion alone (no forces): the centripetal terms of S10, as a vector.
struct ContactDrift {
  Vec3 point_rate;     // m/s, of the geometric contact point
  Vec3 normal_rate;    // 1/s
  Vec3 velocity_rate;  // m/s^2, world axes
};
ContactDrift contact_drift(const World& world, const Contact& contact);

}  // namespace rb
