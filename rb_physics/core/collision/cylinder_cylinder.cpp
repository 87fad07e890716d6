#include <algorithm>
#include <cmath>
#include <vector>

#include "collision/closest.hpp"
#include "collision/convex_axis.hpp"
#include "collision/cylinder_contacts.hpp"
#include "collision/pairs.hpp"
#include "collision/reduce.hpp"

namespace rb {

namespace {

using Part = PlacedCylinder::Part;

ConvexAxis find_axis(const PlacedCylinder& a, const PlacedCylinder& b, double size, double margin) {
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
  search.offer(toward(a.axis), axis);
  const Vec3 cross = a.axis.cross(b.axis);
  const double sine = cross.norm();
  if (sine > tolerance::parallel_edges) {
    search.offer(toward(cross / sine), axis);
  } else {
    const Vec3 radial = b.across(a.center - b.center);
    const double length = radial.norm();
    search.offer(length > 0.0 ? Vec3(radial / length) : b.x, axis);
  }
  if (!axis.fixed && !axis.apart) refine();
  return axis;
}

// Two caps face to face: rim points of each over the other, and where the rims cross.
void cap_on_cap(const PlacedCylinder& a, bool upper_a, const PlacedCylinder& b, bool upper_b,
                double margin, double tolerance, std::vector<ManifoldPoint>& points) {
  const Vec3 n = b.cap_normal(upper_b);
  const Vec3 center_a = a.cap_center(upper_a), center_b = b.cap_center(upper_b);
  const auto add = [&](const Vec3& on_b, std::uint32_t feature_a, std::uint32_t feature_b) {
    // Along n up to the plane of A's cap.
    const Vec3 normal_a = a.cap_normal(upper_a);
    const double separation = normal_a.dot(on_b - center_a) / -normal_a.dot(n);
    if (!(separation <= margin)) return;
    ManifoldPoint p;
    p.normal = n;
    p.separation = separation;
    p.point_b = on_b;
    p.point_a = on_b + p.separation * n;
    p.feature_a = feature_a;
    p.feature_b = feature_b;
    p.kind = ContactKind::FACE_FACE;
    p.normal_owner = NormalOwner::B;
    points.push_back(p);
  };
  const Vec3 apart = b.across(center_a - center_b);
  const double distance = apart.norm();
  const std::uint32_t face_a = PlacedCylinder::cap_feature(upper_a);
  const std::uint32_t face_b = PlacedCylinder::cap_feature(upper_b);
  const bool a_inside = distance + a.radius <= b.radius + tolerance;
  const bool b_inside = distance + b.radius <= a.radius + tolerance;
  for (int k = 0; k < PlacedCylinder::rim_points; ++k) {
    const Vec3 p = center_a + a.radius * a.rim_direction(k);
    const double over = b.across(p - center_b).norm() - b.radius;
    if (!a_inside && (b_inside || over > -tolerance)) continue;
    add(p - n.dot(p - center_b) * n, PlacedCylinder::rim_point_feature(upper_a, k), face_b);
  }
  if (a_inside) return;
  for (int k = 0; k < PlacedCylinder::rim_points; ++k) {
    const Vec3 p = center_b + b.radius * b.rim_direction(k);
    if (!b_inside && a.across(p - center_a).norm() - a.radius > -tolerance) continue;
    add(p, face_a, PlacedCylinder::rim_point_feature(upper_b, k));
  }
  if (b_inside) return;
  const double along = 0.5 * (distance + (b.radius - a.radius) * (b.radius + a.radius) / distance);
  const double across_sq = (b.radius - along) * (b.radius + along);
  if (!(across_sq > 0.0)) return;
  const Vec3 unit = apart / distance, side = n.cross(unit);
  for (int i = 0; i < 2; ++i) {
    const double across = (i == 0 ? 1.0 : -1.0) * std::sqrt(across_sq);
    add(center_b + along * unit + across * side, make_feature(FeatureType::SMOOTH, 4 + i),
        make_feature(FeatureType::SMOOTH, 4 + i));
  }
}

void side_by_side(const PlacedCylinder& a, const PlacedCylinder& b, const ConvexAxis& axis,
                  double tolerance, std::vector<ManifoldPoint>& points) {
  ManifoldPoint p;
  p.normal = axis.normal;
  p.separation = axis.separation;
  p.feature_a = p.feature_b = PlacedCylinder::side_feature();
  if (a.axis.cross(b.axis).norm() > tolerance::parallel) {
    Vec3 on_a, on_b;
    closest_on_lines(a.center, a.axis, b.center, b.axis, on_a, on_b);
    p.point_a = on_a - a.radius * axis.normal;
    p.point_b = on_b + b.radius * axis.normal;
    p.normal_owner = NormalOwner::EDGES;
    points.push_back(p);
    return;
  }
  const double middle = b.axis.dot(a.center - b.center);
  const double low = std::max(-b.half, middle - a.half), high = std::min(b.half, middle + a.half);
  if (!(high - low > tolerance)) return;
  const bool same_way = a.axis.dot(b.axis) > 0.0;
  for (const double at : {high, low}) {
    p.point_b = b.center + at * b.axis + b.radius * axis.normal;
    p.point_a = p.point_b + axis.separation * axis.normal;
    const bool top = at == high, of_b = std::abs(at) == b.half;
    p.feature_b = of_b ? PlacedCylinder::rim_feature(top) : PlacedCylinder::side_feature();
    p.feature_a =
        of_b ? PlacedCylinder::side_feature() : PlacedCylinder::rim_feature(top == same_way);
    points.push_back(p);
  }
}

}  // namespace

void contacts_cylinder_cylinder(const Cylinder& shape_a, const Placement& at_a,
                                const Cylinder& shape_b, const Placement& at_b, double margin,
                                Manifold& out) {
  static thread_local std::vector<ManifoldPoint> points;
  const PlacedCylinder a(shape_a, at_a), b(shape_b, at_b);
  const double small = std::min(a.size(), b.size()), large = std::max(a.size(), b.size());
  const double tolerance = tolerance::coincident * small + 1e-14 * large;
  const ConvexAxis axis = find_axis(a, b, small, margin);
  if (axis.beyond || !(axis.separation <= margin)) return;
  points.clear();
  const Vec3& n = axis.normal;
  const Part part_a = a.part_facing(-n), part_b = b.part_facing(n);
  const bool upper_a = a.axis.dot(n)<0.0, upper_b = b.axis.dot(n)> 0.0;
  if (part_a == Part::CAP && part_b == Part::CAP) {
    cap_on_cap(a, upper_a, b, upper_b, margin, tolerance, points);
  } else if (part_b == Part::CAP) {
    PlanarRegion region{b.cap_normal(upper_b), b.cap_center(upper_b),
                        PlacedCylinder::cap_feature(upper_b), nullptr, b.radius};
    cylinder_on_region(a, region, margin, tolerance, points);
  } else if (part_a == Part::CAP) {
    PlanarRegion region{a.cap_normal(upper_a), a.cap_center(upper_a),
                        PlacedCylinder::cap_feature(upper_a), nullptr, a.radius};
    cylinder_on_region(b, region, margin, tolerance, points);
    mirror(points);
  } else if (part_a == Part::SIDE && part_b == Part::SIDE) {
    side_by_side(a, b, axis, tolerance, points);
  }
  double least = std::numeric_limits<double>::infinity();
  for (const ManifoldPoint& p : points) least = std::min(least, p.separation);
  if (least > axis.separation + tolerance) {
    points.clear();
    ManifoldPoint p;
    p.normal = n;
    p.separation = axis.separation;
    if (axis.certain && !axis.fixed) {
      p.point_a = axis.on_a;
      p.point_b = axis.on_b;
    } else if (part_a == Part::RIM) {
      p.point_a = a(Vec3(-n)).point;
      p.point_b = p.point_a - axis.separation * n;
    } else {
      p.point_b = b(n).point;
      p.point_a = p.point_b + axis.separation * n;
    }
    p.feature_a = part_a == Part::SIDE ? PlacedCylinder::side_feature()
                                       : PlacedCylinder::rim_feature(upper_a);
    p.feature_b = part_b == Part::SIDE ? PlacedCylinder::side_feature()
                                       : PlacedCylinder::rim_feature(upper_b);
    points.push_back(p);
  }
  reduce_cloud(points, n, out);
}

}  // namespace rb
