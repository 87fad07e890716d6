#include "world/retry.hpp"

#include <algorithm>
#include <cmath>

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

namespace {

bool took_part(const World& world, std::int32_t a, std::int32_t b) {
  const auto known = [&](std::int32_t first, std::int32_t second) {
    return std::binary_search(world.known_pairs.begin(), world.known_pairs.end(),
                              std::pair(first, second));
  };
  return known(a, b) || known(b, a);
}

bool overlaps_unexpectedly(World& world) {
  // Of the touch distance: not a matter of rounding.
  const double clear_overlap = is_large_island(world.contacts.size()) ? 1e5 : 10.0;
  // In a heap not one of a correction either, which is far from pushing it out on the other side.
  constexpr double deep = 0.1;  // of the width
  const auto in_heap = [&](std::int32_t row) {
    return world.bodies[row].is_dynamic() && is_large_island(world.islands.of(row).edge_count);
  };
  return any_contact(world, [&](const Contact& c) {
    const double depth = -c.point.separation;
    if (!c.active() || !(depth > clear_overlap * c.touch) ||
        std::binary_search(world.known_pairs.begin(), world.known_pairs.end(), key(c))) {
      return false;
    }
    const double width =
        std::fmin(world.colliders[c.collider_a].width, world.colliders[c.collider_b].width);
    return depth > deep * width || !(in_heap(c.body_a) || in_heap(c.body_b));
  });
}

// m: how far p is from where a free flight with the velocity of the start of the step would lead.
double off_course(const World& world, std::int32_t row, const Vec3& p) {
  const RigidState& start = world.last_good[row];
  const Vec3 way = world.settings.dt * world.bodies[row].inertia.inv_mass * start.p;
  const double length_sq = way.squaredNorm();
  const double share = length_sq > 0.0 ? way.dot(p - start.x) / length_sq : 0.0;
  return (p - start.x - std::clamp(share, 0.0, 1.0) * way).norm();
}

// Fills `strayed`: m, per row, how far a dynamic body's surface went beyond what its candidates
// were found for; and `paths`: boxes that hold the way of its centre of mass.
void follow_paths(const World& world, std::vector<double>& strayed, std::vector<Aabb>& paths) {
  const double h = world.settings.dt;
  strayed.assign(world.bodies.size(), 0.0);
  paths.resize(world.bodies.size());
  for (std::size_t row = 0; row < world.bodies.size(); ++row) {
    const Body& body = world.bodies[row];
    if (!body.is_dynamic()) continue;
    const RigidState& start = world.last_good[row];
    paths[row] = {start.x.cwiseMin(body.state.x), start.x.cwiseMax(body.state.x)};
    const double fall = h * h * body.inertia.inv_mass * world.applied[row].force.norm();
    strayed[row] = off_course(world, static_cast<std::int32_t>(row), body.state.x) - fall;
  }
  const auto pass_by = [&](std::int32_t row, const Vec3& point) {
    if (!world.bodies[row].is_dynamic()) return;
    const double reach = world.reach[row];
    strayed[row] = std::fmax(strayed[row], off_course(world, row, point) - reach);
    paths[row].lower = paths[row].lower.cwiseMin(Vec3(point.array() - reach));
    paths[row].upper = paths[row].upper.cwiseMax(Vec3(point.array() + reach));
  };
  for (const Contact& c : world.contacts) {
    if (c.impulse.isZero(0.0)) continue;
    pass_by(c.body_a, c.point.point_b);
    pass_by(c.body_b, c.point.point_a);
  }
  for (std::size_t row = 0; row < world.bodies.size(); ++row) {
    const Body& body = world.bodies[row];
    if (!body.is_dynamic()) continue;
    const double before = angular_velocity(world.last_good[row], body.inertia).norm();
    const double turn =
        std::fmin(h * body.angular_velocity().norm(), 2.0) - std::fmin(h * before, 2.0);
    strayed[row] += std::fmax(turn, 0.0) * world.reach[row] - world.extra_travel[row];
  }
}

// Where a collider may have been in the step: its box for the next one, and that moved back.
Aabb swept_box(const World& world, std::int32_t k) {
  Aabb box = world.broad_phase.predicted_box(k);
  const Body& body = world.bodies[world.colliders[k].body];
  const Vec3 way = world.settings.dt * body.linear_velocity();
  box.lower = box.lower.cwiseMin(Vec3(box.lower - way));
  box.upper = box.upper.cwiseMax(Vec3(box.upper - way));
  return box;
}

constexpr double surely_not =
    0.5;  // of the widths of two that pass each other: it takes them whole

// Is there a body that could leave its course by so much?
bool any_fast(const World& world) {
  const double h = world.settings.dt;
  return std::any_of(world.colliders.begin(), world.colliders.end(), [&](const Collider& c) {
    const Body& body = world.bodies[c.body];
    if (!body.is_dynamic()) return false;
    const RigidState& start = world.last_good[c.body];
    const double way = h * body.inertia.inv_mass * (body.state.p.norm() + start.p.norm());
    const double spin = body.inertia.inv_body.trace() * body.state.L.norm();
    return way + std::fmin(h * spin, 2.0) * world.reach[c.body] > surely_not * c.width;
  });
}

// A body that was turned aside may have passed something thin that it was no candidate for.
bool may_have_passed(const World& world) {
  if (!any_fast(world)) return false;
  static thread_local std::vector<double> strayed;
  static thread_local std::vector<Aabb> paths;
  static thread_local std::vector<int> near;
  follow_paths(world, strayed, paths);
  double fastest = 0.0;  // m in the step
  for (const Body& body : world.bodies) {
    fastest = std::fmax(fastest, world.settings.dt * body.linear_velocity().norm());
  }
  for (std::size_t k = 0; k < world.colliders.size(); ++k) {
    const Collider& c = world.colliders[k];
    if (!world.bodies[c.body].is_dynamic() || !(strayed[c.body] > surely_not * c.width)) continue;
    Aabb path = paths[c.body];
    path.lower.array() -= c.reach;
    path.upper.array() += c.reach;
    Aabb wide = path;
    wide.lower.array() -= fastest;
    wide.upper.array() += fastest;
    world.broad_phase.query(wide, near);
    for (const int other : near) {
      const Collider& o = world.colliders[other];
      if (o.body == c.body || !world.bodies[o.body].filter.accepts(world.bodies[c.body].filter) ||
          !(strayed[c.body] + std::fmax(strayed[o.body], 0.0) > surely_not * (c.width + o.width)) ||
          !swept_box(world, other).overlaps(path) ||
          took_part(world, static_cast<std::int32_t>(k), other))
        continue;
      return true;
    }
  }
  return false;
}

}  // namespace

bool missed_a_meeting(World& world) {
  return overlaps_unexpectedly(world) || may_have_passed(world);
}

void take_back(World& world) {
  const double h = world.settings.dt;
  ++world.stats.retries;
  static thread_local std::vector<double> strayed;
  static thread_local std::vector<Aabb> paths;
  follow_paths(world, strayed, paths);
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
    const double turn = std::fmin(h * (w - body.angular_velocity()).norm(), 2.0);
    world.extra_travel[row] +=
        std::fmax(h * (v - body.linear_velocity()).norm(), strayed[row]) + turn * world.reach[row];
  }
  for (Contact& c : world.contacts) {
    if (!at_rest(world, c.body_a, c.body_b)) c.impulse = c.moment_a = c.moment_b = Vec3::Zero();
  }
  detect_contacts(world);
}

}  // namespace rb
