#include <cmath>

#include "collision/box_features.hpp"
#include "collision/pairs.hpp"
#include "math/tolerances.hpp"

namespace rb {

void contacts_box_half_space(const Box& a, const Placement& at_a, const HalfSpace& b,
                             const Placement& at_b, double margin, Manifold& out) {
  const Vec3 normal = at_b.rotation * b.normal;
  const Vec3 slope = at_a.rotation.transpose() * normal;  // rise of the box's axes above the plane
  const Vec3& h = a.half_extents;
  const double center_height = normal.dot(at_a.position - at_b.position) - b.offset;
  // The lowest corner, and the axes along which the box lies parallel to the plane.
  int lowest = 0, parallel_bits = 0, parallel_axes = 0;
  double depth = 0.0;
  for (int i = 0; i < 3; ++i) {
    if (slope[i] < 0.0) lowest |= 1 << i;
    depth += std::abs(slope[i]) * h[i];
    if (std::abs(slope[i]) <= tolerance::parallel) {
      parallel_bits |= 1 << i;
      ++parallel_axes;
    }
  }
  if (!(center_height - depth <= margin)) return;
  const ContactKind lowest_kind = parallel_axes == 2   ? ContactKind::FACE_FACE
                                  : parallel_axes == 1 ? ContactKind::EDGE_FACE
                                                       : ContactKind::VERTEX_FACE;
  // Corners in the order of their index. A corner away from the lowest along every tilted axis lies
  // on no face that looks at the plane.
  const int tilted_bits = 7 & ~parallel_bits;
  for (int index = 0; index < 8; ++index) {
    const int away = (index ^ lowest) & tilted_bits;
    if (away == tilted_bits) continue;
    const double separation = center_height + (index & 1 ? slope.x() : -slope.x()) * h.x() +
                              (index & 2 ? slope.y() : -slope.y()) * h.y() +
                              (index & 4 ? slope.z() : -slope.z()) * h.z();
    if (!(separation <= margin)) continue;
    ManifoldPoint p;
    p.normal = normal;
    p.point_a = at_a.apply(box_corner(a, index));
    p.point_b = p.point_a - separation * normal;
    p.separation = separation;
    p.feature_a = make_feature(FeatureType::VERTEX, index);
    p.feature_b = make_feature(FeatureType::FACE, 0);
    p.kind = away == 0 ? lowest_kind : ContactKind::VERTEX_FACE;
    p.normal_owner = NormalOwner::B;
    out.add(p);
  }
}

}  // namespace rb
