// Sleeping (Settings::sleeping): islands that have come to rest are not computed until something
// happens to them. Their contacts and contact wrenches stay as they were in their last step.
//
// What wakes a body: a change of its state, its surface or its wrenches, a moving or changed
// neighbour within reach, an added or removed body. A body that is awake wakes its island.
#pragma once

#include "world/world.hpp"

namespace rb {

// Both at rest, so that nothing between them changes.
inline bool at_rest(const World& world, std::int32_t row_a, std::int32_t row_b) {
  return world.bodies[row_a].asleep && world.bodies[row_b].asleep;
}

// Whether the island sleeps; after wake_islands all its bodies agree.
inline bool sleeps(const World& world, const Island& island) {
  return world.bodies[world.islands.bodies(island).front()].asleep;
}

// Wakes every island that something awake can reach.
void wake_islands(World& world);

// Puts islands to sleep whose bodies have been slow for long enough; tells which others rest.
void fall_asleep(World& world);

void wake_all(World& world);

}  // namespace rb
