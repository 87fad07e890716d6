// Find-intersection (S7): the contact set of two placed shapes.
#include "collision/leaves.hpp"
#include "collision/queries.hpp"

namespace rb {

void find_contacts(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                   double margin, ContactPoints& out) {
  for_each_leaf_manifold(
      a, pose_a, b, pose_b, margin, [&](const Manifold& manifold, const Vec3& origin) {
        for (int i = 0; i < manifold.size(); ++i) {
          const ManifoldPoint& p = manifold[i];
          out.push_back({p.point_a + origin, p.point_b + origin, p.normal, p.separation,
                         pack_features(p.feature_a, p.feature_b), p.kind, p.normal_owner});
        }
      });
}

}  // namespace rb
