#include <algorithm>
#include <cmath>

#include "collision/closest.hpp"
#include "collision/pairs.hpp"
#include "math/tolerances.hpp"

namespace rb {

namespace {

// Axes that meet at a smaller sine touch along a line as well as in a point: both ends are kept.
constexpr double nearly_parallel = 0.1;

struct Rods {
  const Capsule& a;
  const Capsule& b;
  Vec3 center_a, center_b, axis_a, axis_b;

  int feature(double along, double half) const {
    return along == half ? 0 : along == -half ? 1 : 2;
  }

  ManifoldPoint contact(double s, double t) const {
    const Vec3 on_a = center_a + s * axis_a, on_b = center_b + t * axis_b;
    const Vec3 apart = on_a - on_b;
    const double length = apart.norm();
    const double size = a.radius + b.radius;
    const int feature_a = feature(s, a.half_length), feature_b = feature(t, b.half_length);
    ManifoldPoint p;
    if (length > tolerance::closest_direction * size) {
      p.normal = apart / length;
      p.separation = length - size;
    } else {
      // The axes meet: out across both.
      const Vec3 cross = axis_a.cross(axis_b);
      const double sine = cross.norm();
      p.normal = sine > tolerance::parallel ? Vec3(cross / sine) : axis_b.unitOrthogonal();
      if (p.normal.dot(apart) < 0.0) p.normal = -p.normal;
      p.separation = p.normal.dot(apart) - size;
    }
    p.point_a = on_a - a.radius * p.normal;
    p.point_b = on_b + b.radius * p.normal;
    p.feature_a = make_feature(FeatureType::SMOOTH, feature_a);
    p.feature_b = make_feature(FeatureType::SMOOTH, feature_b);
    p.normal_owner = feature_a == 2 && feature_b == 2 ? NormalOwner::EDGES : NormalOwner::CENTERS;
    return p;
  }
};

}  // namespace

void contacts_capsule_capsule(const Capsule& a, const Placement& at_a, const Capsule& b,
                              const Placement& at_b, double margin, Manifold& out) {
  const Rods rods{a, b, at_a.position, at_b.position, at_a.rotation.col(2), at_b.rotation.col(2)};
  const SegmentParameters nearest = closest_on_segments(rods.center_a, rods.axis_a, a.half_length,
                                                        rods.center_b, rods.axis_b, b.half_length);
  const ManifoldPoint closest = rods.contact(nearest.s, nearest.t);
  if (!(closest.separation <= margin)) return;

  if (rods.axis_a.cross(rods.axis_b).squaredNorm() < nearly_parallel * nearly_parallel) {
    // Where the two lie side by side, along A from its centre.
    const Vec3 apart = rods.center_b - rods.center_a;
    const double cosine = rods.axis_a.dot(rods.axis_b), middle = rods.axis_a.dot(apart);
    const double reach = std::abs(cosine) * b.half_length;
    const double low = std::max(-a.half_length, middle - reach);
    const double high = std::min(a.half_length, middle + reach);
    if (high - low > tolerance::coincident * (a.radius + b.radius)) {
      ManifoldPoint ends[2];
      const double limit_a[2] = {high, low};
      for (int i = 0; i < 2; ++i) {
        // The end that stops first, of A or of B, and the point of the other beside it.
        double s = limit_a[i];
        double t;
        if (std::abs(s) == a.half_length) {
          t = closest_on_segment(rods.center_b, rods.axis_b, b.half_length,
                                 rods.center_a + s * rods.axis_a);
        } else {
          t = (i == 0) == (cosine > 0.0) ? b.half_length : -b.half_length;
          s = closest_on_segment(rods.center_a, rods.axis_a, a.half_length,
                                 rods.center_b + t * rods.axis_b);
        }
        ends[i] = rods.contact(s, t);
      }
      const double size = a.radius + b.radius;
      const double least = std::min(ends[0].separation, ends[1].separation);
      if (closest.separation < least - tolerance::coincident * size) out.add(closest);
      for (const ManifoldPoint& end : ends) {
        if (end.separation <= margin) out.add(end);
      }
      return;
    }
  }
  out.add(closest);
}

}  // namespace rb
