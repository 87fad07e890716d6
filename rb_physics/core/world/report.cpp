// What the step leaves for its readers: contact classes (S9), contact wrenches, statistics; and the
// check that every number is finite.
#include <algorithm>
#include <cmath>
#include <mutex>

#include "body/free_motion.hpp"
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

bool turns_too_far(const Body& body, const Vec3& L, double h) {
  if (!body.is_dynamic() || body.inertia.isotropic) return false;
  const Vec3 omega = body.inertia.inv_body * (body.state.q.conjugate() * L);
  return !(std::fabs(h) * omega.norm() <= greatest_turn);
}

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
         spin <= greatest && !turns_too_far(body, s.L, h) &&
         (!body.target || most(body.target->position) <= greatest);
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

namespace {

void add_impulse(Body& body, const Contact& c, bool is_a) {
  if (is_a) {
    body.contact_impulse += c.impulse;
    body.contact_moment += c.moment_a;
  } else {
    body.contact_impulse -= c.impulse;
    body.contact_moment += c.moment_b;
  }
}

// Class (S9), number, and depth of the contacts; with one thread also their sum by body. All in one
// pass: a heap's contacts do not fit into the cache.
void look_through_contacts(World& world) {
  std::mutex mutex;
  std::vector<Contact>& contacts = world.contacts;
  const bool alone = !world.work.crew.helped();
  world.work.crew.share_range(contacts.size(), 512, [&](std::size_t i, std::size_t end) {
    int count = 0;
    double deepest = 0.0;
    PairVelocities motion(world.bodies);
    for (; i < end; ++i) {
      Contact& c = contacts[i];
      const double speed = c.point.normal.dot(motion.relative_at(c, middle_of(c)));
      c.state = classify(speed, tolerance::resting_speed);
      if (c.active()) deepest = std::max(deepest, -c.point.separation);
      const bool carried = !c.impulse.isZero(0.0);
      if (carried || (c.active() && c.touching())) ++count;
      if (!alone || !carried) continue;
      add_impulse(world.bodies[c.body_a], c, true);
      add_impulse(world.bodies[c.body_b], c, false);
    }
    const std::lock_guard lock(mutex);
    world.stats.contacts += count;
    world.stats.max_penetration = std::fmax(world.stats.max_penetration, deepest);
  });
}

// What contacts did to each body, summed in the order of contacts: contact by contact above or,
// when there are several threads, body by body.
void add_up_impulses(World& world) {
  const std::vector<Contact>& contacts = world.contacts;
  std::vector<Body>& bodies = world.bodies;
  Crew& crew = world.work.crew;
  if (crew.helped()) {
    // of_body[first[row]] ...: twice the contact, plus 1 where the body is B.
    static thread_local std::vector<std::size_t> first, of_body;
    static thread_local std::vector<std::pair<std::int32_t, std::int32_t>> bodies_of;
    auto& rows = bodies_of;  // of this thread
    rows.resize(contacts.size());
    crew.share_range(rows.size(), 512, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) rows[i] = {contacts[i].body_a, contacts[i].body_b};
    });
    first.assign(bodies.size() + 2, 0);
    of_body.resize(2 * contacts.size());
    for (const auto& [a, b] : rows) {
      ++first[a + 2];
      ++first[b + 2];
    }
    for (std::size_t row = 2; row < first.size(); ++row) first[row] += first[row - 1];
    for (std::size_t i = 0; i < rows.size(); ++i) {
      of_body[first[rows[i].first + 1]++] = 2 * i;
      of_body[first[rows[i].second + 1]++] = 2 * i + 1;
    }
    const std::vector<std::size_t>&starts = first, &list = of_body;
    crew.share_range(bodies.size(), 32, [&](std::size_t begin, std::size_t end) {
      for (std::size_t row = begin; row < end; ++row) {
        for (std::size_t n = starts[row]; n < starts[row + 1]; ++n) {
          const Contact& c = contacts[list[n] / 2];
          if (!c.impulse.isZero(0.0)) add_impulse(bodies[row], c, list[n] % 2 == 0);
        }
      }
    });
  }
  if (!world.keep_pair_impulses) return;
  for (const Contact& c : contacts) {
    if (!c.impulse.isZero(0.0)) add_to_pair(world.pair_impulses, c);
  }
}

}  // namespace

void finish_step(World& world) {
  if (world.stats.corrections > 0) require_finite(world);
  look_through_contacts(world);
  add_up_impulses(world);
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
