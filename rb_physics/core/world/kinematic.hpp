// Kinematic bodies: they move as they are told, by a twist or towards a target pose.
#pragma once

#include "body/body.hpp"

namespace rb {

// Pose of the body frame t seconds from now, at constant velocity and spin (static: where it is).
Pose kinematic_pose(const Body& body, double t);

// Turns a target pose into the twist that reaches it in h seconds.
void aim_at_target(Body& body, double h);

// Moves the body by h seconds and ends exactly at its target if it has one.
void move_kinematic(Body& body, double h);

}  // namespace rb
