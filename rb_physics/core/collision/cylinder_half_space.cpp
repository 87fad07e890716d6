#include "collision/cylinder_contacts.hpp"
#include "collision/pairs.hpp"
#include "collision/reduce.hpp"

namespace rb {

void contacts_cylinder_half_space(const Cylinder& a, const Placement& at_a, const HalfSpace& b,
                                  const Placement& at_b, double margin, Manifold& out) {
  static thread_local std::vector<ManifoldPoint> points;
  const PlacedCylinder cylinder(a, at_a);
  PlanarRegion region;
  region.normal = at_b.rotation * b.normal;
  region.origin = at_b.position + b.offset * region.normal;
  region.feature = make_feature(FeatureType::FACE, 0);
  points.clear();
  cylinder_on_region(cylinder, region, margin, 0.0, points);
  reduce_cloud(points, region.normal, out);
}

}  // namespace rb
