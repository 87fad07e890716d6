// The queries of S7 between bodies of a world: loops over their colliders.
#pragma once

#include <optional>

#include "collision/queries.hpp"
#include "world/world.hpp"

namespace rb {

bool test_intersection(const World& world, std::int32_t a, std::int32_t b);

// Contact points with separation <= margin, normal from b to a.
ContactPoints find_contacts(const World& world, std::int32_t a, std::int32_t b, double margin);

DistanceResult distance(const World& world, std::int32_t a, std::int32_t b);

// Contact time of the bodies' unconstrained motion (S6) from their present state: gravity and
// applied wrenches act, contacts don't.
ImpactSearch time_of_impact(const World& world, std::int32_t a, std::int32_t b, double t_max);

struct WorldRayHit {
  std::int32_t body = -1;
  RayHit hit;
};
std::optional<WorldRayHit> ray_cast(const World& world, const Vec3& origin, const Vec3& direction);

}  // namespace rb
