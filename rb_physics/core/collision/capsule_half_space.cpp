#include "collision/pairs.hpp"

namespace rb {

void contacts_capsule_half_space(const Capsule& a, const Placement& at_a, const HalfSpace& b,
                                 const Placement& at_b, double margin, Manifold& out) {
  const Vec3 normal = at_b.rotation * b.normal;
  const Vec3 half = a.half_length * at_a.rotation.col(2);
  const double middle = normal.dot(at_a.position - at_b.position) - b.offset;
  const double rise = normal.dot(half);
  for (int end = 0; end < 2; ++end) {
    const double height = end == 0 ? middle + rise : middle - rise;
    const double separation = height - a.radius;
    if (!(separation <= margin)) continue;
    const Vec3 center = end == 0 ? Vec3(at_a.position + half) : Vec3(at_a.position - half);
    ManifoldPoint p;
    p.normal = normal;
    p.point_a = center - a.radius * normal;
    p.point_b = center - height * normal;
    p.separation = separation;
    p.feature_a = make_feature(FeatureType::SMOOTH, end);
    p.feature_b = make_feature(FeatureType::FACE, 0);
    p.normal_owner = NormalOwner::B;
    out.add(p);
  }
}

}  // namespace rb
