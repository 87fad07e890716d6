#include <algorithm>
#include <cmath>
#include <vector>

#include "collision/convex_axis.hpp"
#include "collision/cylinder_axis.hpp"
#include "collision/cylinder_contacts.hpp"
#include "collision/iteration_caps.hpp"
#include "collision/pairs.hpp"
#include "collision/reduce.hpp"

namespace rb {

namespace {

using Part = PlacedCylinder::Part;

// The best axis of two cylinders: of one of them against the other's caps and axis, or rim on rim.
struct PairAxis {
  CylinderAxis axis;  // normal from B to A; `on_cylinder` belongs to A when `of_a`
  bool of_a = true;   // the cylinder of `axis` is A, the other B
  bool rims = false;  // rim on rim, with the points in the places of A's axis

  const Vec3& on_a() const { return of_a ? axis.on_cylinder : axis.on_other; }
  const Vec3& on_b() const { return of_a ? axis.on_other : axis.on_cylinder; }
};

struct PairSearch {
  PairAxis flat, free;
};

void offer_caps(const PlacedCylinder& cylinder, const PlacedCylinder& other,
                CylinderAxisSearch& search) {
  for (const bool upper : {true, false}) {
    const Vec3 n = -cylinder.cap_normal(upper);
    const double separation = n.dot(cylinder.cap_center(upper) - other(n).point);
    search.offer_flat(CylinderAxis::CAP, n, separation, upper ? 0 : 1);
  }
}

PairAxis flipped(const CylinderAxis& axis) {
  PairAxis pair{axis, false, false};
  pair.axis.normal = -axis.normal;
  return pair;
}

PairSearch find_axis(const PlacedCylinder& a, const PlacedCylinder& b, const ConvexAxis& first,
                     const AxisSearch<PlacedCylinder, PlacedCylinder>& rims, double preference,
                     double tolerance) {
  CylinderAxisSearch of_b(b, preference, tolerance), of_a(a, preference, tolerance);
  offer_caps(b, a, of_b);
  offer_caps(a, b, of_a);
  of_b.offer_free_edge({a.center - a.half * a.axis, a.axis, 2.0 * a.half, a.radius, 0});
  of_a.offer_free_edge({b.center - b.half * b.axis, b.axis, 2.0 * b.half, b.radius, 0});
  PairSearch found{flipped(of_b.flat()), flipped(of_b.free())};
  if (of_a.flat().separation > found.flat.axis.separation + preference) {
    found.flat = {of_a.flat(), true, false};
  }
  if (of_a.free().separation > found.free.axis.separation) found.free = {of_a.free(), true, false};
  CylinderAxis axis;
  axis.kind = CylinderAxis::RIM;
  axis.normal = rims.refined(first.normal);
  axis.on_cylinder = a(Vec3(-axis.normal)).point;
  axis.on_other = b(axis.normal).point;
  const Vec3 apart = axis.on_cylinder - axis.on_other;
  axis.separation = axis.normal.dot(apart);
  const bool meet = (apart - axis.separation * axis.normal).norm() <= tolerance;
  const double best = std::max(found.free.axis.separation, found.flat.axis.separation - preference);
  if (!(axis.separation > (meet ? best : best + preference))) return found;
  found.free = {axis, true, true};
  return found;
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
  // With a slight tilt the deepest point is where a rim points down most.
  Vec3 down;
  if (a.across(n).norm() > tolerance::coincident && a.radial(-n, down)) {
    const Vec3 lowest = center_a + a.radius * down;
    if (b.across(lowest - center_b).norm() <= b.radius + tolerance) {
      add(lowest - n.dot(lowest - center_b) * n, PlacedCylinder::rim_feature(upper_a), face_b);
    }
    const Vec3 highest = center_b + b.radius * b.across(down).normalized();
    if (a.across(highest - center_a).norm() <= a.radius + tolerance) {
      add(highest, face_a, PlacedCylinder::rim_feature(upper_b));
    }
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

// The sides along each other: both ends of the common part. False: there is none, or it is not
// where the two are nearest.
bool side_by_side(const PlacedCylinder& a, const PlacedCylinder& b, const CylinderAxis& axis,
                  double tolerance, std::vector<ManifoldPoint>& points) {
  Vec3 outward;
  if (a.part_facing(-axis.normal) != Part::SIDE || !a.radial(axis.normal, outward)) return false;
  const Vec3 line = a.center - a.radius * outward;
  SideOverlap side;
  if (!side_overlap(b, axis.normal, line, a.axis, a.half, tolerance, side)) return false;
  const Vec3& n = side.normal;
  const double proven = n.dot(a(Vec3(-n)).point - b(n).point);
  if (!carries(side, proven, axis.separation, tolerance)) return false;
  const bool same_way = a.axis.dot(b.axis) > 0.0;
  for (int i = 0; i < 2; ++i) {
    ManifoldPoint p;
    p.normal = n;
    p.separation = side.separation[i];
    p.point_a = line + side.t[i] * a.axis;
    p.point_b = p.point_a - p.separation * n;
    const bool of_b = side.of_cylinder[i];
    p.feature_b =
        of_b ? PlacedCylinder::rim_feature((i == 0) == same_way) : PlacedCylinder::side_feature();
    p.feature_a = of_b ? PlacedCylinder::side_feature() : PlacedCylinder::rim_feature(i == 0);
    points.push_back(p);
  }
  return true;
}

// The one point of an axis that is no cap's.
ManifoldPoint single_contact(const PlacedCylinder& a, const PlacedCylinder& b,
                             const PairAxis& found) {
  const auto feature = [](const PlacedCylinder& c, const Vec3& toward) {
    return c.part_facing(toward) == Part::SIDE
               ? PlacedCylinder::side_feature()
               : PlacedCylinder::rim_feature(c.axis.dot(toward) > 0.0);
  };
  ManifoldPoint p;
  p.normal = found.axis.normal;
  p.separation = found.axis.separation;
  p.point_a = found.on_a();
  p.point_b = found.on_b();
  p.feature_a = feature(a, -p.normal);
  p.feature_b = feature(b, p.normal);
  if (found.axis.kind == CylinderAxis::CROSSING) p.normal_owner = NormalOwner::EDGES;
  return p;
}

// The deepest point alone, should rounding leave nothing over a cap.
ManifoldPoint deepest_contact(const PlacedCylinder& a, const PlacedCylinder& b,
                              const PairAxis& found) {
  ManifoldPoint p;
  p.normal = found.axis.normal;
  p.separation = found.axis.separation;
  const bool upper = found.axis.feature == 0;
  // Of a cap that lies flat, the point nearest the other's axis.
  const auto farthest = [](const PlacedCylinder& c, const Vec3& toward, const Vec3& other) -> Vec3 {
    if (c.part_facing(toward) != Part::CAP) return c(toward).point;
    const Vec3 cap = c.cap_center(c.axis.dot(toward) > 0.0), aside = c.across(other - cap);
    const double distance = aside.norm();
    return distance > c.radius ? Vec3(cap + (c.radius / distance) * aside) : Vec3(cap + aside);
  };
  if (found.of_a) {
    p.point_b = farthest(b, p.normal, a.center);
    p.point_a = p.point_b + p.separation * p.normal;
    p.feature_a = PlacedCylinder::cap_feature(upper);
    p.feature_b = PlacedCylinder::rim_feature(b.axis.dot(p.normal) > 0.0);
    p.normal_owner = NormalOwner::A;
  } else {
    p.point_a = farthest(a, -p.normal, b.center);
    p.point_b = p.point_a - p.separation * p.normal;
    p.feature_a = PlacedCylinder::rim_feature(a.axis.dot(p.normal) < 0.0);
    p.feature_b = PlacedCylinder::cap_feature(upper);
    p.normal_owner = NormalOwner::B;
  }
  return p;
}

void flat_contacts(const PlacedCylinder& a, const PlacedCylinder& b, const PairAxis& found,
                   double margin, double tolerance, std::vector<ManifoldPoint>& points) {
  const Vec3& n = found.axis.normal;
  const bool upper = found.axis.feature == 0;
  const auto region = [&](const PlacedCylinder& c) {
    return PlanarRegion{c.cap_normal(upper), c.cap_center(upper),
                        PlacedCylinder::cap_feature(upper), nullptr, c.radius};
  };
  const PlacedCylinder& other = found.of_a ? b : a;
  const Vec3 toward = found.of_a ? n : Vec3(-n);  // from the cap outward to it, reversed
  if (other.part_facing(toward) == Part::CAP) {
    const bool facing = other.axis.dot(toward) > 0.0;
    if (found.of_a) {
      cap_on_cap(b, facing, a, upper, margin, tolerance, points);
      mirror(points);
    } else {
      cap_on_cap(a, facing, b, upper, margin, tolerance, points);
    }
  } else if (found.of_a) {
    cylinder_on_region(b, region(a), margin, tolerance, points);
    mirror(points);
  } else {
    cylinder_on_region(a, region(b), margin, tolerance, points);
  }
}

// Caps that lean a little against each other: what else of them is near.
void nearly_flat_contacts(const PlacedCylinder& a, const PlacedCylinder& b, const Vec3& normal,
                          double margin, double tolerance, std::vector<ManifoldPoint>& points) {
  static thread_local std::vector<ManifoldPoint> more;
  const bool upper_a = a.axis.dot(normal)<0.0, upper_b = b.axis.dot(normal)> 0.0;
  const Vec3 cap_a = a.cap_normal(upper_a);
  if (!nearly_flat(cap_a, normal) || !nearly_flat(cap_a, b.cap_normal(upper_b))) return;
  more.clear();
  cap_on_cap(a, upper_a, b, upper_b, margin, tolerance, more);
  add_shallower(more, tolerance, points);
}

}  // namespace

void contacts_cylinder_cylinder(const Cylinder& shape_a, const Placement& at_a,
                                const Cylinder& shape_b, const Placement& at_b, double margin,
                                Manifold& out) {
  static thread_local std::vector<ManifoldPoint> points;
  const PlacedCylinder a(shape_a, at_a), b(shape_b, at_b);
  const double small = std::min(a.size(), b.size()), large = std::max(a.size(), b.size());
  const double tolerance = tolerance::coincident * small + 1e-14 * large;
  const double preference = tolerance::axis_preference * small + 1e-15 * large;
  const AxisSearch search(a, b, small);
  const ConvexAxis first = search.first(a.center - b.center, margin);
  if (first.beyond) return;
  if (!first.least) count_iteration_cap();
  const PairSearch found = find_axis(a, b, first, search, preference, tolerance);
  const bool flat = found.flat.axis.separation >= found.free.axis.separation - preference;
  const CylinderAxis& axis = flat ? found.flat.axis : found.free.axis;
  if (!(axis.separation <= margin)) return;
  points.clear();
  if (flat) {
    flat_contacts(a, b, found.flat, margin, tolerance, points);
    if (least_separation(points) > axis.separation + tolerance) {
      points.clear();
      points.push_back(found.free.axis.separation >= axis.separation - tolerance
                           ? single_contact(a, b, found.free)
                           : deepest_contact(a, b, found.flat));
    }
  } else if (found.free.rims || !side_by_side(a, b, axis, tolerance, points)) {
    points.push_back(single_contact(a, b, found.free));
  }
  nearly_flat_contacts(a, b, axis.normal, margin, tolerance, points);
  reduce_cloud(points, axis.normal, out);
}

}  // namespace rb
