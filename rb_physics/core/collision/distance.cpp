// Distance and nearest points of two placed shapes: the contact of least separation.
#include <limits>

#include "collision/leaves.hpp"
#include "collision/queries.hpp"

namespace rb {

DistanceResult distance(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  DistanceResult nearest{infinity, Vec3::Zero(), Vec3::Zero(), Vec3::UnitZ()};
  for_each_leaf_manifold(
      a, pose_a, b, pose_b, infinity, [&](const Manifold& manifold, const Vec3& origin) {
        for (int i = 0; i < manifold.size(); ++i) {
          const ManifoldPoint& p = manifold[i];
          if (!(p.separation < nearest.distance)) continue;
          nearest = {p.separation, p.point_a + origin, p.point_b + origin, p.normal};
        }
      });
  return nearest;
}

}  // namespace rb
