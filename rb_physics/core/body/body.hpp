// A rigid body: state (S6), inertia, surface, and what acts on it from outside.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "body/applied_wrench.hpp"
#include "body/collision_filter.hpp"
#include "body/material.hpp"
#include "body/state.hpp"
#include "math/rotation.hpp"

namespace rb {

// STATIC never moves, KINEMATIC moves as it is told and pushes with infinite mass, DYNAMIC obeys
// S6.
enum class BodyType : std::uint8_t { STATIC = 0, DYNAMIC = 1, KINEMATIC = 2 };

struct Body {
  std::string name;
  BodyType type = BodyType::DYNAMIC;
  RigidState state;  // dynamic: all four; otherwise x and q
  Inertia inertia;
  Vec3 center_of_mass = Vec3::Zero();  // m, body coordinates
  Material material;
  CollisionFilter filter;
  Vec3 velocity = Vec3::Zero();    // m/s, of the centre of mass; kinematic bodies only
  Vec3 spin = Vec3::Zero();        // rad/s, world axes; kinematic bodies only
  std::optional<Pose> target;      // kinematic: pose of the body frame at the end of the next step
  bool stop_after_target = false;  // no twist was given with the target
  std::vector<AppliedWrench> wrenches;  // in the order of their sources

  // Settings::sleeping. Dynamic: its island is at rest and is not computed. Others: they have not
  // moved or changed since the last step.
  bool asleep = false;
  double still_time = 0.0;  // s it has been slower than tolerance::sleep_speed

  void wake() {
    asleep = false;
    still_time = 0.0;
  }

  // Warm start of the minimum-norm forces (contact/problem.hpp), per second, and how often in a row
  // one was looked for in vain.
  Vec6 certificate = Vec6::Zero();
  int vain_searches = 0;

  // Contact impulse on the body, N s, and its moment about the moving centre of mass, N m s; world
  // axes.
  Vec3 contact_impulse = Vec3::Zero();  // last step
  Vec3 contact_moment = Vec3::Zero();
  Vec3 contact_impulse_sum = Vec3::Zero();  // since it was last drained
  Vec3 contact_moment_sum = Vec3::Zero();

  bool is_dynamic() const { return type == BodyType::DYNAMIC; }
  Pose pose() const { return {state.x - state.q * center_of_mass, state.q}; }
  Vec3 linear_velocity() const {
    return is_dynamic() ? rb::linear_velocity(state, inertia) : velocity;
  }
  Vec3 angular_velocity() const {
    return is_dynamic() ? rb::angular_velocity(state, inertia) : spin;
  }

  void set_pose(const Pose& pose) {
    wake();
    state.q = pose.orientation;
    state.x = pose.apply(center_of_mass);
  }
  void set_linear_velocity(const Vec3& v) {
    wake();
    if (is_dynamic())
      state.p = inertia.mass * v;
    else
      velocity = v;
  }
  void set_angular_velocity(const Vec3& w) {
    wake();
    if (is_dynamic())
      state.L = angular_momentum(state.q, inertia, w);
    else
      spin = w;
  }
};

}  // namespace rb
