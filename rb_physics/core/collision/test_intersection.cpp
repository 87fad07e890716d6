// Test-intersection (S7): do two placed shapes share a point?
#include <stdexcept>

#include "collision/leaves.hpp"
#include "collision/queries.hpp"

namespace rb {

bool test_intersection(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  if (is_surface(a) && is_surface(b)) {
    throw std::invalid_argument("test_intersection: two meshes or height fields are not supported");
  }
  if (is_surface(b) && !std::holds_alternative<Compound>(a)) {
    return meets_surface(a, pose_a, b, pose_b);
  }
  if (is_surface(a)) return test_intersection(b, pose_b, a, pose_a);
  bool touching = false;
  for_each_leaf_manifold(a, pose_a, b, pose_b, 0.0, [&](const Manifold& manifold, const Vec3&) {
    touching = touching || manifold.least_separation(0) <= 0.0;
  });
  return touching;
}

}  // namespace rb
