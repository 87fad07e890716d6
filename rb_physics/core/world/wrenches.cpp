// What acts on the bodies from outside during a step: gravity and held wrenches, evaluated at its
// start.
#include <algorithm>
#include <cmath>

#include "world/kinematic.hpp"
#include "world/sleep.hpp"
#include "world/step.hpp"

namespace rb {
namespace {

// Sum of the held wrenches in world axes. One that ends within the step acts with the part of its
// time that is left, so that its impulse is force * duration whatever dt is.
Wrench held_wrenches(const Body& body, double h) {
  Wrench sum;
  for (const AppliedWrench& w : body.wrenches) {
    const Wrench now = in_world(w, body.state.q, body.center_of_mass);
    const double share = w.remaining > 0.0 && w.remaining < h ? w.remaining / h : 1.0;
    sum.force += share * now.force;
    sum.torque += share * now.torque;
  }
  return sum;
}

// A held wrench ends within the step.
bool ends(const Body& body, double h) {
  return std::any_of(body.wrenches.begin(), body.wrenches.end(),
                     [h](const AppliedWrench& w) { return w.remaining >= 0.0 && w.remaining < h; });
}

}  // namespace

Wrench external_wrench(const World& world, const Body& body) {
  if (!body.is_dynamic()) return {};
  Wrench w = held_wrenches(body, world.settings.dt);
  w.force += body.inertia.mass * world.settings.gravity;
  if (body.inertia.inv_body.isZero(0.0)) w.torque.setZero();  // a particle (S1)
  return w;
}

namespace {

// Gravity and held wrenches of one body; throws Diverged for what would leave the numbers.
void begin_body(World& world, std::size_t row) {
  const double h = world.settings.dt;
  Body& body = world.bodies[row];
  world.last_good[row] = body.state;
  body.contact_impulse = body.contact_moment = Vec3::Zero();
  world.applied[row] = Wrench{};
  // What was set from outside and would leave the numbers: said before anything moves.
  if (world.geometry_dirty && !within_numbers(body, h))
    throw Diverged(world.step_count, static_cast<std::int32_t>(row));
  if (body.type == BodyType::KINEMATIC) {
    if (body.target || !body.velocity.isZero(0.0) || !body.spin.isZero(0.0)) body.wake();
    aim_at_target(body, h);
  }
  if (!body.is_dynamic()) return;
  if (body.asleep && (!body.state.p.isZero(0.0) || !body.state.L.isZero(0.0) || ends(body, h)))
    body.wake();
  world.applied[row] = external_wrench(world, body);
  // Likewise a wrench that would carry the state there.
  const Wrench& w = world.applied[row];
  constexpr double greatest = 1e120;     // N, N m: squares of it must not overflow either
  constexpr double greatest_way = 1e30;  // m in the step
  const double force = w.force.cwiseAbs().maxCoeff();
  if (!(force <= greatest && h * h * body.inertia.inv_mass * force <= greatest_way &&
        w.torque.cwiseAbs().maxCoeff() <= greatest) ||
      turns_too_far(body, body.state.L + h * w.torque, h)) {
    throw Diverged(world.step_count, static_cast<std::int32_t>(row));
  }
}

}  // namespace

void begin_step(World& world) {
  world.stats = Stats{};
  world.last_good.resize(world.bodies.size());
  world.work.crew.share_range(world.bodies.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) begin_body(world, row);
  });
  // What lay on something that was changed is awake even if it touches it no more.
  const bool any_asleep = std::any_of(world.bodies.begin(), world.bodies.end(),
                                      [](const Body& body) { return body.asleep; });
  for (std::size_t i = 0; any_asleep && i < world.contacts.size(); ++i) {
    const Contact& c = world.contacts[i];
    if (world.bodies[c.body_a].asleep == world.bodies[c.body_b].asleep) continue;
    for (const std::int32_t row : {c.body_a, c.body_b}) {
      Body& body = world.bodies[row];
      if (body.is_dynamic() && body.asleep) body.wake();
    }
  }
  share_contacts(world, [&](Contact& c) {
    if (!any_asleep || !at_rest(world, c.body_a, c.body_b))
      c.impulse = c.moment_a = c.moment_b = Vec3::Zero();
  });
}

void expire_wrenches(World& world) {
  const double h = world.settings.dt;
  for (Body& body : world.bodies) {
    const std::size_t ended = std::erase_if(body.wrenches, [h](AppliedWrench& w) {
      if (w.remaining < 0.0) return false;
      w.remaining -= h;
      return w.remaining <= 1e-9 * h;  // a rounding error is not another step
    });
    if (ended > 0) body.wake();
  }
}

}  // namespace rb
