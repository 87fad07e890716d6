// Adding and removing bodies: rows, colliders and broad-phase proxies stay in step.
#include <cmath>

#include "world/sleep.hpp"

namespace rb {
namespace {

void add_collider(World& world, const Shape& shape, const Pose& local, std::int32_t row,
                  std::int32_t part) {
  Collider c;
  c.shape = shape;
  c.local = local;
  c.body = row;
  c.part = part;
  c.size = characteristic_size(shape);
  c.width = least_width(shape);
  const Body& body = world.bodies[row];
  c.reach = bounding_radius(shape, local.apply_inverse(body.center_of_mass));
  if (std::isfinite(c.reach)) world.reach[row] = std::fmax(world.reach[row], c.reach);
  const bool passive = !body.is_dynamic();
  if (const auto* plane = std::get_if<HalfSpace>(&shape)) {
    const Pose pose = body.pose() * local;
    const Vec3 n = pose.rotate(plane->normal);
    world.broad_phase.insert_half_space(n, plane->offset + n.dot(pose.position), body.filter,
                                        passive);
  } else {
    world.broad_phase.insert(bounding_box(shape, body.pose() * local), body.filter, passive);
  }
  world.colliders.push_back(std::move(c));
}

}  // namespace

std::int32_t add_body(World& world, Body body, const Shape& shape) {
  const auto row = static_cast<std::int32_t>(world.bodies.size());
  world.bodies.push_back(std::move(body));
  world.applied.emplace_back();
  world.travel.push_back(0.0);
  world.reach.push_back(0.0);
  world.extra_travel.push_back(0.0);
  if (const auto* compound = std::get_if<Compound>(&shape)) {
    std::int32_t part = 0;
    for (const CompoundPart& p : compound->data->parts)
      add_collider(world, p.shape, p.pose, row, part++);
  } else if (!std::holds_alternative<Particle>(shape) || world.bodies[row].is_dynamic()) {
    add_collider(world, shape, Pose{}, row, 0);
  }
  wake_all(world);
  world.geometry_dirty = true;
  return row;
}

void remove_body(World& world, std::int32_t row) {
  for (auto k = static_cast<std::int32_t>(world.colliders.size()) - 1; k >= 0; --k) {
    if (world.colliders[k].body != row) continue;
    world.broad_phase.remove(k);
    world.colliders.erase(world.colliders.begin() + k);
    std::erase_if(world.contacts,
                  [k](const Contact& c) { return c.collider_a == k || c.collider_b == k; });
    for (Contact& c : world.contacts) {
      if (c.collider_a > k) --c.collider_a;
      if (c.collider_b > k) --c.collider_b;
    }
  }
  for (Collider& c : world.colliders) {
    if (c.body > row) --c.body;
  }
  for (Contact& c : world.contacts) {
    if (c.body_a > row) --c.body_a;
    if (c.body_b > row) --c.body_b;
  }
  std::erase_if(world.pair_impulses,
                [row](const PairImpulse& p) { return p.body_a == row || p.body_b == row; });
  for (PairImpulse& p : world.pair_impulses) {
    if (p.body_a > row) --p.body_a;
    if (p.body_b > row) --p.body_b;
  }
  world.bodies.erase(world.bodies.begin() + row);
  world.applied.erase(world.applied.begin() + row);
  world.travel.erase(world.travel.begin() + row);
  world.reach.erase(world.reach.begin() + row);
  world.extra_travel.erase(world.extra_travel.begin() + row);
  wake_all(world);
  world.geometry_dirty = true;
}

}  // namespace rb
