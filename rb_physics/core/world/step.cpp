// The step, as a table of contents. Each line is a stage with a file of its own.
#include "world/step.hpp"

#include "world/correct.hpp"
#include "world/detect.hpp"

namespace rb {

void step(World& world) {
  begin_step(world);  // world/wrenches.cpp   gravity, applied wrenches, kinematic targets
  if (needs_detection(world)) {  //                      something moved from outside
    detect_contacts(
        world);  // world/detect.cpp     broad phase, narrow phase, feature matching (S7, S8)
  }
  build_islands(world);  // island/island.cpp    who may meet whom
  advance_islands(
      world);  // world/advance.cpp    impacts (S11-S14), rest and friction (S16), free motion (S6)
  move_kinematics(world);    // world/kinematic.cpp
  detect_contacts(world);    // world/detect.cpp     the contact set at the end of the step
  correct_positions(world);  // world/correct.cpp    overlap out, energy unchanged
  finish_step(world);        // world/report.cpp     contact states (S9), wrenches, statistics
}

}  // namespace rb
