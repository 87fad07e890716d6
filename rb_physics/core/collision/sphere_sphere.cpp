#include <cmath>

#include "collision/pairs.hpp"

namespace rb {

void contacts_ball_ball(const Ball& a, const Placement& at_a, const Ball& b, const Placement& at_b,
                        double margin, Manifold& out) {
  const Vec3 apart = at_a.position - at_b.position;
  const double length = apart.norm();
  const double separation = length - a.radius - b.radius;
  if (!(separation <= margin)) return;
  ManifoldPoint p;
  p.normal =
      length > 0.0 ? Vec3(apart / length) : Vec3::UnitZ();  // concentric: any direction parts
  p.point_a = at_a.position - a.radius * p.normal;
  p.point_b = at_b.position + b.radius * p.normal;
  p.separation = separation;
  p.feature_a = make_feature(a.is_particle ? FeatureType::VERTEX : FeatureType::SMOOTH, 0);
  p.feature_b = make_feature(b.is_particle ? FeatureType::VERTEX : FeatureType::SMOOTH, 0);
  out.add(p);
}

}  // namespace rb
