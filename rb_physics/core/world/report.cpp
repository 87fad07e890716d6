// What the step leaves for its readers: contact classes (S9), contact wrenches, statistics; and the
// check that every number is finite.
#include <algorithm>
#include <cmath>

#include "contact/builder.hpp"
#include "world/sleep.hpp"
#include "world/step.hpp"

namespace rb {
namespace {

// Adds a contact's impulse to the sum of its two bodies.
void add_to_pair(std::vector<PairImpulse>& sums, const Contact& c) {
  const auto before = [](const PairImpulse& p, const Contact& contact) {
    return p.body_a != contact.body_a ? p.body_a < contact.body_a : p.body_b < contact.body_b;
  };
  auto sum = std::lower_bound(sums.begin(), sums.end(), c, before);
  if (sum == sums.end() || sum->body_a != c.body_a || sum->body_b != c.body_b) {
    sum = sums.insert(sum, PairImpulse{});
    sum->body_a = c.body_a;
    sum->body_b = c.body_b;
  }
  sum->impulse += c.impulse;
  sum->moment_a += c.moment_a;
  sum->moment_b += c.moment_b;
}

}  // namespace

// Far below where squares overflow: broad and narrow phase work with products of these.
bool within_numbers(const Body& body, double h) {
  constexpr double greatest = 1e30;            // m, m/s, rad/s; m in a step
  constexpr double greatest_momentum = 1e120;  // N s, N m s
  const auto most = [](const Vec3& v) { return v.cwiseAbs().maxCoeff(); };
  const RigidState& s = body.state;
  const double speed = most(body.linear_velocity());
  const double spin =
      body.is_dynamic() ? most(s.L) * body.inertia.inv_body.diagonal().maxCoeff() : most(body.spin);
  return s.x.allFinite() && s.q.coeffs().allFinite() && s.p.allFinite() && s.L.allFinite() &&
         most(s.x) <= greatest && most(s.p) <= greatest_momentum &&
         most(s.L) <= greatest_momentum && speed <= greatest && h * speed <= greatest &&
         spin <= greatest && (!body.target || most(body.target->position) <= greatest);
}

void classify_contacts(World& world) {
  for (Contact& c : world.contacts) {
    const Vec3 point = 0.5 * (c.point.point_a + c.point.point_b);
    const double speed = c.point.normal.dot(
        relative_velocity(world.bodies[c.body_a], world.bodies[c.body_b], point));
    c.state = classify(speed, tolerance::resting_speed);
  }
}

void require_finite(World& world) {
  for (std::size_t row = 0; row < world.bodies.size(); ++row) {
    if (within_numbers(world.bodies[row], world.settings.dt)) continue;
    for (std::size_t k = 0; k < world.bodies.size(); ++k)
      world.bodies[k].state = world.last_good[k];
    world.contacts.clear();
    world.geometry_dirty = true;
    throw Diverged(world.step_count, static_cast<std::int32_t>(row));
  }
}

void finish_step(World& world) {
  require_finite(world);
  classify_contacts(world);
  for (const Contact& c : world.contacts) {
    if ((c.active() && c.touching()) || !c.impulse.isZero(0.0)) ++world.stats.contacts;
    if (c.active())
      world.stats.max_penetration = std::fmax(world.stats.max_penetration, -c.point.separation);
    if (c.impulse.isZero(0.0)) continue;
    Body& a = world.bodies[c.body_a];
    Body& b = world.bodies[c.body_b];
    a.contact_impulse += c.impulse;
    a.contact_moment += c.moment_a;
    b.contact_impulse -= c.impulse;
    b.contact_moment += c.moment_b;
    if (world.keep_pair_impulses) add_to_pair(world.pair_impulses, c);
  }
  world.worst.residual = std::fmax(world.worst.residual, world.stats.residual);
  world.worst.max_penetration = std::fmax(world.worst.max_penetration, world.stats.max_penetration);
  world.worst.contacts = std::max(world.worst.contacts, world.stats.contacts);
  for (Body& body : world.bodies) {
    body.contact_impulse_sum += body.contact_impulse;
    body.contact_moment_sum += body.contact_moment;
  }
  fall_asleep(world);
  expire_wrenches(world);
  ++world.step_count;
  if (world.keep_hashes) world.hashes.push_back(state_hash(world));
}

}  // namespace rb
