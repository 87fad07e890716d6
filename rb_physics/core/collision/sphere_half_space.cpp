#include "collision/pairs.hpp"

namespace rb {

void contacts_ball_half_space(const Ball& a, const Placement& at_a, const HalfSpace& b,
                              const Placement& at_b, double margin, Manifold& out) {
  const Vec3 normal = at_b.rotation * b.normal;
  const double height = normal.dot(at_a.position - at_b.position) - b.offset;
  const double separation = height - a.radius;
  if (!(separation <= margin)) return;
  ManifoldPoint p;
  p.normal = normal;
  p.point_a = at_a.position - a.radius * normal;
  p.point_b = at_a.position - height * normal;
  p.separation = separation;
  p.feature_a = make_feature(a.is_particle ? FeatureType::VERTEX : FeatureType::SMOOTH, 0);
  p.feature_b = make_feature(FeatureType::FACE, 0);
  p.kind = a.is_particle ? ContactKind::VERTEX_FACE : ContactKind::SMOOTH;
  p.normal_owner = NormalOwner::B;
  out.add(p);
}

}  // namespace rb
