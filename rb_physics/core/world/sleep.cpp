#include "world/sleep.hpp"

#include <algorithm>
#include <cmath>

#include "math/tolerances.hpp"

namespace rb {
namespace {

// No point of the body moves faster than the sleeping speed.
bool slow(const World& world, std::int32_t row) {
  const Body& body = world.bodies[row];
  return body.linear_velocity().norm() + body.angular_velocity().norm() * world.reach[row] <=
         tolerance::sleep_speed;
}

// The forces of the last step cancel: they are what a body at rest feels.
bool balanced(const World& world, std::int32_t row) {
  const Body& body = world.bodies[row];
  const Wrench& w = world.applied[row];
  const double dt = world.settings.dt;
  const double reach = std::fmax(world.reach[row], 1e-300);
  const double scale =
      dt * (w.force.norm() + w.torque.norm() / reach) + body.inertia.mass * tolerance::sleep_speed;
  return (body.contact_impulse + dt * w.force).norm() <= tolerance::sleep_balance * scale &&
         (body.contact_moment + dt * w.torque).norm() <= tolerance::sleep_balance * scale * reach;
}

}  // namespace

void wake_islands(World& world) {
  if (!world.settings.sleeping) return;
  for (const Island& island : world.islands.all()) {
    const auto rows = world.islands.bodies(island);
    const auto edges = world.islands.edges(island);
    const auto awake = [&](std::int32_t row) { return !world.bodies[row].asleep; };
    const bool any_awake = std::any_of(rows.begin(), rows.end(), awake) ||
                           std::any_of(edges.begin(), edges.end(), [&](std::int32_t i) {
                             return awake(world.contacts[i].body_b);
                           });
    if (!any_awake) continue;
    for (const std::int32_t i : edges) {
      Contact& c = world.contacts[i];
      // What it carried in the step before stands there until now.
      if (at_rest(world, c.body_a, c.body_b)) c.impulse = c.moment_a = c.moment_b = Vec3::Zero();
    }
    for (const std::int32_t row : rows) {
      if (world.bodies[row].asleep) world.bodies[row].wake();
    }
  }
}

void fall_asleep(World& world) {
  if (!world.settings.sleeping) return;
  const double dt = world.settings.dt;
  for (std::size_t row = 0; row < world.bodies.size(); ++row) {
    Body& body = world.bodies[row];
    if (!body.is_dynamic()) {
      const bool still = !body.target && body.velocity.isZero(0.0) && body.spin.isZero(0.0);
      body.asleep = still && body.still_time > 0.0;  // after a whole step without a change
      body.still_time = still ? body.still_time + dt : 0.0;
    } else if (!body.asleep) {
      const bool still = slow(world, static_cast<std::int32_t>(row));
      body.still_time = still ? body.still_time + dt : 0.0;
    }
  }
  for (const Contact& c : world.contacts) {
    Body& a = world.bodies[c.body_a];
    Body& b = world.bodies[c.body_b];
    const bool disturbed = c.role == ContactRole::GHOST || (!b.is_dynamic() && !b.asleep);
    if (disturbed && !a.asleep) a.still_time = 0.0;
  }
  for (const Island& island : world.islands.all()) {
    const auto rows = world.islands.bodies(island);
    if (sleeps(world, island)) continue;
    const bool ready = std::all_of(rows.begin(), rows.end(), [&](std::int32_t row) {
      return world.bodies[row].still_time >= tolerance::sleep_time && balanced(world, row);
    });
    if (!ready) continue;
    for (const std::int32_t row : rows) {
      Body& body = world.bodies[row];
      body.asleep = true;
      body.state.p = body.state.L = Vec3::Zero();
    }
  }
  for (const Body& body : world.bodies) world.stats.asleep += body.is_dynamic() && body.asleep;
}

void wake_all(World& world) {
  for (Body& body : world.bodies) body.wake();
}

}  // namespace rb
