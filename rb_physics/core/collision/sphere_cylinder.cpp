#include <cmath>

#include "collision/ball_contact.hpp"

namespace rb {

void contacts_ball_cylinder(const Ball& a, const Placement& at_a, const Cylinder& b,
                            const Placement& at_b, double margin, Manifold& out) {
  const Vec3 center = at_b.apply_inverse(at_a.position);
  const double across = std::sqrt(center.x() * center.x() + center.y() * center.y());
  // On the axis any sideways direction is as good as another: x.
  const Vec3 radial =
      across > 0.0 ? Vec3(center.x() / across, center.y() / across, 0.0) : Vec3(Vec3::UnitX());
  const double beyond_side = across - b.radius;
  const double beyond_cap = std::abs(center.z()) - b.half_length;
  const bool upper = center.z() >= 0.0;
  const Vec3 cap = upper ? Vec3(Vec3::UnitZ()) : Vec3(-Vec3::UnitZ());
  double height;
  Vec3 normal, on_cylinder = center;
  std::uint32_t feature;
  if (beyond_side > 0.0 && beyond_cap > 0.0) {
    height = std::sqrt(beyond_side * beyond_side + beyond_cap * beyond_cap);
    normal = (beyond_side * radial + beyond_cap * cap) / height;
    on_cylinder = b.radius * radial + b.half_length * cap;
    feature = make_feature(FeatureType::SMOOTH, upper ? 0 : 1);
  } else if (beyond_side > beyond_cap) {
    height = beyond_side;
    normal = radial;
    on_cylinder = b.radius * radial + Vec3(0.0, 0.0, center.z());
    feature = make_feature(FeatureType::SMOOTH, 2);
  } else {
    height = beyond_cap;
    normal = cap;
    on_cylinder.z() = upper ? b.half_length : -b.half_length;
    feature = make_feature(FeatureType::FACE, upper ? 0 : 1);
  }
  add_ball_contact(a, at_a, at_b, normal, on_cylinder, height, feature, margin, out);
}

}  // namespace rb
