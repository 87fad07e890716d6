#include <algorithm>
#include <cmath>
#include <vector>

#include "collision/closest.hpp"
#include "collision/convex_axis.hpp"
#include "collision/cylinder_contacts.hpp"
#include "collision/pairs.hpp"
#include "collision/rod.hpp"

namespace rb {

namespace {

using Part = PlacedCylinder::Part;

// For the capsule's axis; the radius comes off afterwards.
ConvexAxis find_axis(const Rod& a, const PlacedCylinder& b, double size, double margin) {
  const AxisSearch search(a, b, size);
  ConvexAxis axis = search.first(a.center - b.center, margin);
  if (axis.beyond) return axis;
  const Vec3 first = axis.normal;
  const auto toward = [&](const Vec3& n) { return n.dot(first) >= 0.0 ? n : Vec3(-n); };
  const auto refine = [&] {
    search.refine_across(a.axis, axis);
    search.refine_across(b.axis, axis);
    search.refine(axis);
  };
  if (axis.apart && !axis.certain) refine();
  search.offer(toward(b.axis), axis);
  const Vec3 cross = a.axis.cross(b.axis);
  const double sine = cross.norm();
  if (sine > tolerance::parallel_edges) search.offer(toward(cross / sine), axis);
  for (int i = 0; i < 2; ++i) {
    const Vec3 radial = b.across(a.end(i) - b.center);
    const double length = radial.norm();
    search.offer(length > 0.0 ? Vec3(radial / length) : b.x, axis);
  }
  if (!axis.fixed && !axis.apart) refine();
  return axis;
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

void side_contacts(const Rod& a, const PlacedCylinder& b, const ConvexAxis& axis, double tolerance,
                   Manifold& out) {
  const Vec3 cross = a.axis.cross(b.axis);
  if (cross.norm() <= tolerance::parallel) {
    const double middle = a.axis.dot(b.center - a.center);
    const double low = std::max(-a.half, middle - b.half), high = std::min(a.half, middle + b.half);
    if (high - low > tolerance) {
      for (const double at : {high, low}) {
        ManifoldPoint p = a.contact(at, axis.normal, axis.separation);
        p.feature_b = std::abs(at) == a.half
                          ? PlacedCylinder::side_feature()
                          : PlacedCylinder::rim_feature((at == high) == (a.axis.dot(b.axis) > 0.0));
        out.add(p);
      }
      return;
    }
  }
  // One end lower, or the middle across.
  const double slope = axis.normal.dot(a.axis);
  double along = slope > 0.0 ? -a.half : a.half;
  NormalOwner owner = NormalOwner::CENTERS;
  if (std::abs(slope) <= tolerance::parallel) {
    Vec3 on_a, on_b;
    closest_on_lines(a.center, a.axis, b.center, b.axis, on_a, on_b);
    const double s = a.axis.dot(on_a - a.center);
    if (std::abs(s) < a.half) {
      along = s;
      owner = NormalOwner::EDGES;
    } else {
      along = s > 0.0 ? a.half : -a.half;
    }
  }
  ManifoldPoint p = a.contact(along, axis.normal, axis.separation);
  p.feature_b = PlacedCylinder::side_feature();
  p.normal_owner = owner;
  out.add(p);
}

}  // namespace

void contacts_capsule_cylinder(const Capsule& shape_a, const Placement& at_a,
                               const Cylinder& shape_b, const Placement& at_b, double margin,
                               Manifold& out) {
  const Rod a(shape_a, at_a);
  const PlacedCylinder b(shape_b, at_b);
  const double size_a = a.radius + a.half;
  const double small = std::min(size_a, b.size()), large = std::max(size_a, b.size());
  const double tolerance = tolerance::coincident * small + 1e-14 * large;
  const ConvexAxis axis = find_axis(a, b, small, margin + a.radius);
  if (axis.beyond || !(axis.separation - a.radius <= margin)) return;
  const Vec3& n = axis.normal;
  const Part part = b.part_facing(n);
  const bool upper = b.axis.dot(n) > 0.0;
  const int first = out.size();
  if (part == Part::CAP) {
    cap_contacts(a, b, upper, margin, tolerance, out);
  } else if (part == Part::SIDE) {
    side_contacts(a, b, axis, tolerance, out);
  }
  if (out.least_separation(first) <= axis.separation - a.radius + tolerance) return;
  out.truncate(first);
  ManifoldPoint p;
  p.normal = n;
  p.separation = axis.separation - a.radius;
  const bool known = axis.certain && !axis.fixed;
  const Vec3 on_b = known ? axis.on_b : b(n).point;
  const Vec3 on_axis = known ? axis.on_a : Vec3(on_b + axis.separation * n);
  p.point_a = on_axis - a.radius * n;
  p.point_b = on_b;
  const double along = a.axis.dot(on_axis - a.center);
  p.feature_a =
      a.feature(std::abs(along) >= a.half - tolerance ? std::copysign(a.half, along) : 0.0);
  p.feature_b =
      part == Part::SIDE ? PlacedCylinder::side_feature() : PlacedCylinder::rim_feature(upper);
  out.add(p);
}

}  // namespace rb
