// The kinematics of a contact (S10) of a world: how its separation, point and normal move.
#pragma once

#include "contact/kinematics.hpp"
#include "world/world.hpp"

namespace rb {

// d, d', d'' from the present state, gravity, applied wrenches and the contact forces of the last
// step.
ContactKinematics contact_rates(const World& world, const Contact& contact);

ContactDrift contact_drift(const World& world, const Contact& contact);

}  // namespace rb
