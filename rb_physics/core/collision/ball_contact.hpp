// The one contact of a ball with a solid, once the nearest point of its surface is known.
#pragma once

#include "collision/manifold.hpp"
#include "collision/pairs.hpp"

namespace rb {

// `normal` (unit, outward) and `on_b` (m) in B's coordinates; `height`: of the centre above the
// surface, m, negative inside. Adds nothing beyond `margin`.
inline void add_ball_contact(const Ball& a, const Placement& at_a, const Placement& at_b,
                             const Vec3& normal, const Vec3& on_b, double height,
                             std::uint32_t feature_b, double margin, Manifold& out) {
  if (!(height - a.radius <= margin)) return;
  const bool on_face = feature_type(feature_b) == FeatureType::FACE;
  ManifoldPoint p;
  p.normal = at_b.rotation * normal;
  p.point_a = at_a.position - a.radius * p.normal;
  p.point_b = at_b.apply(on_b);
  p.separation = height - a.radius;
  p.feature_a = make_feature(a.is_particle ? FeatureType::VERTEX : FeatureType::SMOOTH, 0);
  p.feature_b = feature_b;
  p.kind = a.is_particle && on_face ? ContactKind::VERTEX_FACE : ContactKind::SMOOTH;
  p.normal_owner = on_face ? NormalOwner::B : NormalOwner::CENTERS;
  out.add(p);
}

}  // namespace rb
