// Test-intersection (S7): do two placed shapes share a point?
#include "collision/leaves.hpp"
#include "collision/queries.hpp"

namespace rb {

bool test_intersection(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  bool touching = false;
  for_each_leaf_manifold(a, pose_a, b, pose_b, 0.0, [&](const Manifold& manifold, const Vec3&) {
    touching = touching || manifold.least_separation(0) <= 0.0;
  });
  return touching;
}

}  // namespace rb
