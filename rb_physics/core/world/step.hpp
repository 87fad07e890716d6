// The stages of a step that are too small for a header of their own.
#pragma once

#include "world/world.hpp"

namespace rb {

// world/wrenches.cpp
void begin_step(World& world);
Wrench external_wrench(const World& world, const Body& body);  // gravity + held wrenches, as of now
void expire_wrenches(World& world);

// world/advance_all.cpp
bool needs_detection(const World& world);
void build_islands(World& world);
void advance_islands(World& world);
Workers& workers_of(World& world);  // as many as settings.threads says
void move_kinematics(World& world);

// world/report.cpp
void classify_contacts(World& world);
// Position, velocities and target are finite and so small that products of them are.
bool within_numbers(const Body& body, double h);
void require_finite(World& world);  // throws Diverged, with the last good state in place
void finish_step(World& world);

}  // namespace rb
