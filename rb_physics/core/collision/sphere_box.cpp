#include <cmath>

#include "collision/ball_contact.hpp"
#include "collision/box_features.hpp"
#include "math/tolerances.hpp"

namespace rb {

namespace {

double corner_tolerance(const Box& b) { return tolerance::coincident * b.half_extents.maxCoeff(); }

int faces_near(const Box& b, const Vec3& inside) {
  return static_cast<int>(
      ((b.half_extents - inside.cwiseAbs()).array() <= corner_tolerance(b)).count());
}

// A particle on an edge or a corner, or inside within rounding of it, touches every face that meets
// there: which of them it came over is not for its position to say.
void contacts_of_corner(const Placement& at_a, const Box& b, const Placement& at_b,
                        const Vec3& center, double margin, Manifold& out) {
  for (int i = 0; i < 3; ++i) {
    const double height = std::abs(center[i]) - b.half_extents[i];
    if (height < -corner_tolerance(b) || !(height <= margin)) continue;
    const double sign = center[i] >= 0.0 ? 1.0 : -1.0;
    ManifoldPoint p;
    p.normal = sign * at_b.rotation.col(i);
    p.point_a = at_a.position;
    p.point_b = p.point_a - height * p.normal;
    p.separation = height;
    p.feature_a = make_feature(FeatureType::VERTEX, 0);
    p.feature_b = make_feature(FeatureType::FACE, 2 * i + (sign > 0.0 ? 1 : 0));
    p.kind = ContactKind::VERTEX_FACE;
    p.normal_owner = NormalOwner::B;
    out.add(p);
  }
}

}  // namespace

void contacts_ball_box(const Ball& a, const Placement& at_a, const Box& b, const Placement& at_b,
                       double margin, Manifold& out) {
  const Vec3 center = at_b.apply_inverse(at_a.position);
  const Vec3& h = b.half_extents;
  const Vec3 nearest = center.cwiseMax(-h).cwiseMin(h);
  const Vec3 outside = center - nearest;
  std::uint32_t feature;
  Vec3 normal, on_box;
  double height;  // of the centre above the surface
  if (outside.squaredNorm() > 0.0) {
    height = outside.norm();
    normal = outside / height;
    on_box = nearest;
    int corner = 0, free_bits = 0;
    for (int i = 0; i < 3; ++i) {
      if (outside[i] == 0.0) free_bits |= 1 << i;
      if (outside[i] > 0.0) corner |= 1 << i;
    }
    feature = box_feature(corner, free_bits);
  } else if (a.is_particle && faces_near(b, center) > 1) {
    contacts_of_corner(at_a, b, at_b, center, margin, out);
    return;
  } else {
    // Inside: out through the nearest face; the lowest axis decides a tie.
    int axis = 0;
    for (int i = 1; i < 3; ++i) {
      if (h[i] - std::abs(center[i]) < h[axis] - std::abs(center[axis])) axis = i;
    }
    const bool positive = center[axis] >= 0.0;
    height = std::abs(center[axis]) - h[axis];
    normal = Vec3::Zero();
    normal[axis] = positive ? 1.0 : -1.0;
    on_box = center;
    on_box[axis] = positive ? h[axis] : -h[axis];
    feature = make_feature(FeatureType::FACE, 2 * axis + (positive ? 1 : 0));
  }
  add_ball_contact(a, at_a, at_b, normal, on_box, height, feature, margin, out);
}

}  // namespace rb
