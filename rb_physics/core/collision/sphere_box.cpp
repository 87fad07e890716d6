#include <cmath>

#include "collision/box_features.hpp"
#include "collision/pairs.hpp"

namespace rb {

void contacts_ball_box(const Ball& a, const Placement& at_a, const Box& b, const Placement& at_b,
                       double margin, Manifold& out) {
  const Vec3 center = at_b.apply_inverse(at_a.position);
  const Vec3& h = b.half_extents;
  const Vec3 nearest = center.cwiseMax(-h).cwiseMin(h);
  const Vec3 outside = center - nearest;
  ManifoldPoint p;
  Vec3 normal, on_box;
  double height;  // of the centre above the surface
  if (outside.squaredNorm() > 0.0) {
    height = outside.norm();
    if (!(height - a.radius <= margin)) return;
    normal = outside / height;
    on_box = nearest;
    int corner = 0, free_bits = 0;
    for (int i = 0; i < 3; ++i) {
      if (outside[i] == 0.0) free_bits |= 1 << i;
      if (outside[i] > 0.0) corner |= 1 << i;
    }
    p.feature_b = box_feature(corner, free_bits);
  } else {
    // Inside: out through the nearest face; the lowest axis decides a tie.
    int axis = 0;
    for (int i = 1; i < 3; ++i) {
      if (h[i] - std::abs(center[i]) < h[axis] - std::abs(center[axis])) axis = i;
    }
    const bool positive = center[axis] >= 0.0;
    height = std::abs(center[axis]) - h[axis];
    if (!(height - a.radius <= margin)) return;
    normal = Vec3::Zero();
    normal[axis] = positive ? 1.0 : -1.0;
    on_box = center;
    on_box[axis] = positive ? h[axis] : -h[axis];
    p.feature_b = make_feature(FeatureType::FACE, 2 * axis + (positive ? 1 : 0));
  }
  const bool on_face = feature_type(p.feature_b) == FeatureType::FACE;
  p.normal = at_b.rotation * normal;
  p.point_a = at_a.position - a.radius * p.normal;
  p.point_b = at_b.apply(on_box);
  p.separation = height - a.radius;
  p.feature_a = make_feature(a.is_particle ? FeatureType::VERTEX : FeatureType::SMOOTH, 0);
  p.kind = a.is_particle && on_face ? ContactKind::VERTEX_FACE : ContactKind::SMOOTH;
  p.normal_owner = on_face ? NormalOwner::B : NormalOwner::CENTERS;
  out.add(p);
}

}  // namespace rb
