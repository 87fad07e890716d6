#include <cmath>

#include "collision/closest.hpp"
#include "collision/pairs.hpp"

namespace rb {

void contacts_ball_capsule(const Ball& a, const Placement& at_a, const Capsule& b,
                           const Placement& at_b, double margin, Manifold& out) {
  const Vec3 axis = at_b.rotation.col(2);
  const double along = closest_on_segment(at_b.position, axis, b.half_length, at_a.position);
  const Vec3 on_axis = at_b.position + along * axis;
  const Vec3 apart = at_a.position - on_axis;
  const double length = apart.norm();
  const double separation = length - a.radius - b.radius;
  if (!(separation <= margin)) return;
  ManifoldPoint p;
  // On the axis: out sideways, along the capsule's own x axis.
  p.normal = length > 0.0 ? Vec3(apart / length) : Vec3(at_b.rotation.col(0));
  p.point_a = at_a.position - a.radius * p.normal;
  p.point_b = on_axis + b.radius * p.normal;
  p.separation = separation;
  p.feature_a = make_feature(a.is_particle ? FeatureType::VERTEX : FeatureType::SMOOTH, 0);
  p.feature_b = make_feature(FeatureType::SMOOTH, along == b.half_length    ? 0
                                                  : along == -b.half_length ? 1
                                                                            : 2);
  out.add(p);
}

}  // namespace rb
