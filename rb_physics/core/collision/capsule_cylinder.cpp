#include <algorithm>
#include <cmath>

#include "collision/cylinder_axis.hpp"
#include "collision/cylinder_contacts.hpp"
#include "collision/pairs.hpp"
#include "collision/rod.hpp"

namespace rb {

namespace {

using Part = PlacedCylinder::Part;

// Between the capsule's axis and the cylinder, which is the first here; the radius comes off
// afterwards.
CylinderAxisSearch find_axis(const Rod& a, const PlacedCylinder& b, double preference,
                             double tolerance) {
  CylinderAxisSearch search(b, preference, tolerance);
  for (const bool upper : {true, false}) {
    const Vec3 n = -b.cap_normal(upper);
    search.offer_flat(CylinderAxis::CAP, n, n.dot(b.cap_center(upper) - a(n).point), upper ? 0 : 1);
  }
  for (int i = 0; i < 2; ++i) {
    search.offer_corner(a.end(i), i, [&](const Vec3& n) { return n.dot(a(n).point); });
  }
  search.offer_free_edge({a.end(1), a.axis, 2.0 * a.half, 0.0, 0});
  return search;
}

void cap_contacts(const Rod& a, const PlacedCylinder& b, bool upper, double margin,
                  double tolerance, Manifold& out) {
  const PlanarRegion cap{b.cap_normal(upper), b.cap_center(upper),
                         PlacedCylinder::cap_feature(upper), nullptr, b.radius};
  double low = 0.0, high = 1.0;
  if (!cap.clip(a.end(1), a.end(0), tolerance, low, high)) return;
  const auto add = [&](double t) {
    const double along = t == 1.0 ? a.half : t == 0.0 ? -a.half : (2.0 * t - 1.0) * a.half;
    const double separation = cap.height(a.at(along));
    if (!(separation - a.radius <= margin)) return;
    ManifoldPoint p = a.contact(along, cap.normal, separation);
    p.feature_b = std::abs(along) == a.half ? cap.feature
                                            : make_feature(FeatureType::SMOOTH, t == high ? 4 : 5);
    p.normal_owner = NormalOwner::B;
    out.add(p);
  };
  add(high);
  if ((high - low) * 2.0 * a.half > tolerance) add(low);
}

// The capsule along the cylinder: both ends of the common part. False: there is none, or it is not
// where the two are nearest.
bool side_by_side(const Rod& a, const PlacedCylinder& b, const CylinderAxis& axis, double tolerance,
                  Manifold& out) {
  SideOverlap side;
  if (!side_overlap(b, -axis.normal, a.center, a.axis, a.half, tolerance, side)) return false;
  const Vec3& n = side.normal;
  const double proven = n.dot(a(Vec3(-n)).point - b(n).point);
  if (!carries(side, proven, axis.separation, tolerance)) return false;
  const bool same_way = a.axis.dot(b.axis) > 0.0;
  for (int i = 0; i < 2; ++i) {
    ManifoldPoint p = a.contact(side.t[i], n, side.separation[i]);
    p.feature_b = side.of_cylinder[i] ? PlacedCylinder::rim_feature((i == 0) == same_way)
                                      : PlacedCylinder::side_feature();
    out.add(p);
  }
  return true;
}

}  // namespace

void contacts_capsule_cylinder(const Capsule& shape_a, const Placement& at_a,
                               const Cylinder& shape_b, const Placement& at_b, double margin,
                               Manifold& out) {
  const Rod a(shape_a, at_a);
  const PlacedCylinder b(shape_b, at_b);
  const double size_a = a.radius + a.half;
  const double small = std::min(size_a, b.size()), large = std::max(size_a, b.size());
  const double reach = a.half + a.radius + std::sqrt(b.radius * b.radius + b.half * b.half);
  if ((a.center - b.center).norm() > reach + margin) return;
  const double tolerance = tolerance::coincident * small + 1e-14 * large;
  const double preference = tolerance::axis_preference * small + 1e-15 * large;
  const CylinderAxisSearch found = find_axis(a, b, preference, tolerance);
  const CylinderAxis& axis = found.best();
  const double separation = axis.separation - a.radius;
  if (!(separation <= margin)) return;
  const Vec3 n = -axis.normal;
  const int first = out.size();
  const CylinderAxis* free = &found.free();
  if (found.prefers_flat()) {
    cap_contacts(a, b, axis.feature == 0, margin, tolerance, out);
    if (out.least_separation(first) <= separation + tolerance) return;
    out.truncate(first);
    if (free->separation < axis.separation - tolerance) {
      // Rounding left nothing over the cap.
      const double along = a.axis.dot(n) > 0.0 ? -a.half : a.half;
      ManifoldPoint p = a.contact(along, n, axis.separation);
      p.feature_b = PlacedCylinder::cap_feature(axis.feature == 0);
      p.normal_owner = NormalOwner::B;
      out.add(p);
      return;
    }
  } else if (side_by_side(a, b, axis, tolerance, out)) {
    return;
  }
  ManifoldPoint p;
  p.normal = -free->normal;
  p.separation = free->separation - a.radius;
  p.point_a = free->on_other - a.radius * p.normal;
  p.point_b = free->on_cylinder;
  const double along = a.axis.dot(free->on_other - a.center);
  const bool end = free->kind == CylinderAxis::CORNER || std::abs(along) >= a.half - tolerance;
  p.feature_a = a.feature(end ? std::copysign(a.half, along) : 0.0);
  p.feature_b = b.part_facing(p.normal) == Part::SIDE
                    ? PlacedCylinder::side_feature()
                    : PlacedCylinder::rim_feature(b.axis.dot(p.normal) > 0.0);
  if (free->kind == CylinderAxis::CROSSING && !end) p.normal_owner = NormalOwner::EDGES;
  out.add(p);
}

}  // namespace rb
