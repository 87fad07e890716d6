#pragma once

#include "world/world.hpp"

namespace rb {

// Removes overlap at the end of a step without touching any velocity. Contacts are found again as
// needed.
void correct_positions(World& world);

// rad: how far a correction of this overlap (m) may turn a body that reaches this far (m).
inline double overlap_turn(double overlap, double reach) { return 10.0 * overlap / reach; }

// The inverse inertia for turns of at most `turn` rad that leave the kinetic energy at constant L
// as it is: none about omega x L, unless it is as good as zero.
Mat3 harmless_inverse_inertia(const World& world, std::int32_t row, const Mat3& inverse,
                              double turn);

}  // namespace rb
