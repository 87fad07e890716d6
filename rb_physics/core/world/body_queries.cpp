#include "world/body_queries.hpp"

#include "collision/sweep.hpp"
#include "world/detect.hpp"
#include "world/free_sweep.hpp"
#include "world/step.hpp"

namespace rb {
namespace {

template <class Visit>
void for_collider_pairs(const World& world, std::int32_t a, std::int32_t b, Visit visit) {
  for (const Collider& ca : world.colliders) {
    if (ca.body != a) continue;
    for (const Collider& cb : world.colliders) {
      if (cb.body == b) visit(ca, cb);
    }
  }
}

}  // namespace

bool test_intersection(const World& world, std::int32_t a, std::int32_t b) {
  const Pose pose_a = world.bodies.at(a).pose();
  const Pose pose_b = world.bodies.at(b).pose();
  bool found = false;
  for_collider_pairs(world, a, b, [&](const Collider& ca, const Collider& cb) {
    found = found || test_intersection(ca.shape, pose_a * ca.local, cb.shape, pose_b * cb.local);
  });
  return found;
}

ContactPoints find_contacts(const World& world, std::int32_t a, std::int32_t b, double margin) {
  const Pose pose_a = world.bodies.at(a).pose();
  const Pose pose_b = world.bodies.at(b).pose();
  ContactPoints all;
  ContactPoints some;
  for_collider_pairs(world, a, b, [&](const Collider& ca, const Collider& cb) {
    some.clear();
    find_contacts(ca.shape, pose_a * ca.local, cb.shape, pose_b * cb.local, margin, some);
    for (ContactPoint& p : some) {
      p.feature = with_parts(p.feature, ca.part, cb.part);
      all.push_back(p);
    }
  });
  return all;
}

DistanceResult distance(const World& world, std::int32_t a, std::int32_t b) {
  const Pose pose_a = world.bodies.at(a).pose();
  const Pose pose_b = world.bodies.at(b).pose();
  std::optional<DistanceResult> nearest;
  for_collider_pairs(world, a, b, [&](const Collider& ca, const Collider& cb) {
    const DistanceResult d = distance(ca.shape, pose_a * ca.local, cb.shape, pose_b * cb.local);
    if (!nearest || d.distance < nearest->distance) nearest = d;
  });
  return nearest.value();
}

ImpactSearch time_of_impact(const World& world, std::int32_t a, std::int32_t b, double t_max) {
  const auto sweep_of = [&](std::int32_t row) {
    const Body& body = world.bodies.at(row);
    return FreeSweep(body, body.state, external_wrench(world, body), t_max);
  };
  constexpr int most_queries = 100000;  // of a pair of parts; a second or less
  const FreeSweep sweep_a = sweep_of(a);
  const FreeSweep sweep_b = sweep_of(b);
  ImpactSearch first;
  for_collider_pairs(world, a, b, [&](const Collider& ca, const Collider& cb) {
    const PartSweep part_a(sweep_a, ca.local);
    const PartSweep part_b(sweep_b, cb.local);
    keep_earlier(first, find_time_of_impact(ca.shape, part_a, cb.shape, part_b,
                                            first.time.value_or(t_max), most_queries));
  });
  return first;
}

std::optional<WorldRayHit> ray_cast(const World& world, const Vec3& origin, const Vec3& direction) {
  std::optional<WorldRayHit> nearest;
  for (const Collider& c : world.colliders) {
    const auto hit = ray_cast(c.shape, world.bodies[c.body].pose() * c.local, origin, direction);
    if (hit && (!nearest || hit->distance < nearest->hit.distance)) {
      nearest = WorldRayHit{c.body, *hit};
    }
  }
  return nearest;
}

}  // namespace rb
