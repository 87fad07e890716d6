#include "world/retry.hpp"

#include <algorithm>

#include "world/detect.hpp"
#include "world/sleep.hpp"
#include "world/step.hpp"

namespace rb {
namespace {

std::pair<std::int32_t, std::int32_t> key(const Contact& c) { return {c.collider_a, c.collider_b}; }

}  // namespace

void remember(World& world) {
  world.kinematic_start.clear();
  for (const Body& body : world.bodies) {
    if (body.type == BodyType::KINEMATIC) {
      world.kinematic_start.push_back({body.state, body.velocity, body.spin, body.target});
    }
  }
}

bool missed_a_meeting(World& world) {
  // Of the touch distance: not a matter of rounding; in a heap not one of a correction either.
  const double clear_overlap = is_large_island(world.contacts.size()) ? 1e5 : 10.0;
  return any_contact(world, [&](const Contact& c) {
    return c.active() && c.point.separation < -clear_overlap * c.touch &&
           !std::binary_search(world.known_pairs.begin(), world.known_pairs.end(), key(c));
  });
}

void take_back(World& world) {
  const double h = world.settings.dt;
  ++world.stats.retries;
  std::size_t kinematic = 0;
  for (std::size_t row = 0; row < world.bodies.size(); ++row) {
    Body& body = world.bodies[row];
    const Vec3 v = body.linear_velocity();
    const Vec3 w = body.angular_velocity();
    body.state = world.last_good[row];
    if (body.type == BodyType::KINEMATIC) {
      const KinematicStart& start = world.kinematic_start[kinematic++];
      body.velocity = start.velocity;
      body.spin = start.spin;
      body.target = start.target;
    }
    if (!body.is_dynamic()) continue;
    world.extra_travel[row] += h * (v - body.linear_velocity()).norm() +
                               h * (w - body.angular_velocity()).norm() * world.reach[row];
  }
  for (Contact& c : world.contacts) {
    if (!at_rest(world, c.body_a, c.body_b)) c.impulse = c.moment_a = c.moment_b = Vec3::Zero();
  }
  detect_contacts(world);
}

}  // namespace rb
