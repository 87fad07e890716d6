// A step that missed a meeting is taken back and made again with wider eyes.
//
// Candidates are found from the velocities at the start of a step. A body that is struck within the
// step may reach one it was no candidate for; the end of the step then shows an overlap of a pair
// that took no part, or something thin lies beside the body's way. The step is undone and repeated,
// with the reach of every body widened by what it gained.
#pragma once

#include "world/world.hpp"

namespace rb {

// Notes what must come back if the step is undone.
void remember(World& world);

// True when contacts of a pair that took no part overlap at the end of the step, or a body that was
// turned aside may have passed something thin.
bool missed_a_meeting(World& world);

// Back to the start of the step; contacts are found again with the wider reach.
void take_back(World& world);

}  // namespace rb
