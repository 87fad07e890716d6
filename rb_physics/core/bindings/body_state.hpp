// What bindings share about setting a body's state: it stays finite, and a refusal leaves it as it
// was.
#pragma once

#include "bindings/arguments.hpp"
#include "body/body.hpp"
#include "math/rotation.hpp"

namespace rb::bindings {

// Moves and turns the body; its velocities stay.
inline void set_pose(Body& body, const Pose& pose) {
  const Vec3 v = body.linear_velocity();
  const Vec3 w = body.angular_velocity();
  body.set_pose(pose);
  body.set_linear_velocity(v);
  body.set_angular_velocity(w);
}

// Makes the change; raises SceneError where a product of finite numbers overflowed, as in mass
// times a huge velocity.
template <class Change>
void change_state(Body& body, const std::string& field, const InputArray& value, Change change) {
  const RigidState before = body.state;
  change(body);
  const RigidState& s = body.state;
  if (s.x.allFinite() && s.p.allFinite() && s.L.allFinite()) return;
  body.state = before;
  refuse(field, value, "so small that position and momenta stay finite", body.name);
}

}  // namespace rb::bindings
