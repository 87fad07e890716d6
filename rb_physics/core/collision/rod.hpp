// The axis of a placed capsule: a segment, which the radius surrounds.
#pragma once

#include "collision/gjk.hpp"
#include "collision/manifold.hpp"
#include "shape/shape.hpp"

namespace rb {

struct Rod {
  Vec3 center, axis;
  double half, radius;

  Rod(const Capsule& shape, const Placement& at)
      : center(at.position),
        axis(at.rotation.col(2)),
        half(shape.half_length),
        radius(shape.radius) {}

  Vec3 at(double along) const { return center + along * axis; }
  Vec3 end(int i) const { return at(i == 0 ? half : -half); }
  // Capsule feature of a point of the axis: SMOOTH 0 and 1 the ends, 2 between them.
  std::uint32_t feature(double along) const {
    return make_feature(FeatureType::SMOOTH, along == half ? 0 : along == -half ? 1 : 2);
  }
  SupportPoint operator()(const Vec3& d) const {
    const int i = axis.dot(d) >= 0.0 ? 0 : 1;
    return {end(i), i};
  }
  double curvature(const Vec3&, const Vec3&, const Vec3&) const { return 0.0; }

  // Contact of the capsule where its axis at `along` is `core_separation` (m) off the other
  // surface.
  ManifoldPoint contact(double along, const Vec3& normal, double core_separation) const {
    const Vec3 on_axis = at(along);
    ManifoldPoint p;
    p.normal = normal;
    p.separation = core_separation - radius;
    p.point_a = on_axis - radius * normal;
    p.point_b = on_axis - core_separation * normal;
    p.feature_a = feature(along);
    return p;
  }
};

}  // namespace rb
