#pragma once

#include "world/world.hpp"

namespace rb {

// Removes overlap at the end of a step without touching any velocity. Contacts are found again as
// needed.
void correct_positions(World& world);

}  // namespace rb
