#include "collision/cylinder_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "math/tolerances.hpp"

namespace rb {

namespace {

ManifoldPoint on_region(const PlanarRegion& region, const Vec3& p, std::uint32_t feature,
                        ContactKind kind) {
  ManifoldPoint point;
  point.normal = region.normal;
  point.separation = region.height(p);
  point.point_a = p;
  point.point_b = p - point.separation * region.normal;
  point.feature_a = feature;
  point.feature_b = region.feature;
  point.kind = kind;
  point.normal_owner = NormalOwner::B;
  return point;
}

}  // namespace

void cylinder_on_region(const PlacedCylinder& a, const PlanarRegion& region, double margin,
                        double tolerance, std::vector<ManifoldPoint>& points) {
  const auto add = [&](const Vec3& p, std::uint32_t feature, ContactKind kind) {
    if (region.height(p) <= margin) points.push_back(on_region(region, p, feature, kind));
  };
  const std::size_t first = points.size();
  const double rise = a.axis.dot(region.normal);
  const bool upper = rise < 0.0;  // which cap is the lower one over the region
  const Vec3 cap = a.cap_center(upper);
  const Vec3 outward = a.across(region.normal);
  const double length = outward.norm();
  // A tilt as small as this moves no point by more than a tolerance; up to `parallel` the rim's
  // lowest point counts too, and the caps still lie flat.
  if (length <= tolerance::coincident) {
    for (int k = 0; k < PlacedCylinder::rim_points; ++k) {
      const Vec3 p = cap + a.radius * a.rim_direction(k);
      if (!region.under(p, tolerance)) continue;
      add(p, PlacedCylinder::rim_point_feature(upper, k), ContactKind::FACE_FACE);
    }
    if (region.polygon) {
      polygon_on_cap(a, upper, *region.polygon, CapNormal::OF_POLYGON, margin, tolerance, points);
    }
    return;
  }
  const bool flat = length <= tolerance::parallel;
  Vec3 down;
  a.radial(-region.normal, down);
  const Vec3 lowest = cap + a.radius * down, other = a.cap_center(!upper) + a.radius * down;
  double low = 0.0, high = 1.0;
  if (region.clip(lowest, other, tolerance, low, high)) {
    const Vec3 along = other - lowest;
    add(low > 0.0 ? Vec3(lowest + low * along) : lowest,
        low > 0.0 ? PlacedCylinder::side_feature() : PlacedCylinder::rim_feature(upper),
        ContactKind::SMOOTH);
    if (!flat && (high - low) * 2.0 * a.half > tolerance) {
      add(high < 1.0 ? Vec3(lowest + high * along) : other,
          high < 1.0 ? make_feature(FeatureType::SMOOTH, 3) : PlacedCylinder::rim_feature(!upper),
          ContactKind::SMOOTH);
    }
  }
  if (std::abs(rise) <= tolerance::parallel) return;
  if (flat) {
    for (std::size_t i = first; i < points.size(); ++i) points[i].kind = ContactKind::FACE_FACE;
  }
  // Further points of the lower rim, all but the fixed one beside the lowest.
  int beside = 0;
  for (int k = 1; k < PlacedCylinder::rim_points; ++k) {
    if (down.dot(a.rim_direction(k)) > down.dot(a.rim_direction(beside))) beside = k;
  }
  for (int k = 0; k < PlacedCylinder::rim_points; ++k) {
    const Vec3 p = cap + a.radius * a.rim_direction(k);
    if (k == beside || !region.under(p, tolerance)) continue;
    add(p, PlacedCylinder::rim_point_feature(upper, k),
        flat ? ContactKind::FACE_FACE : ContactKind::SMOOTH);
  }
  if (flat && region.polygon) {
    polygon_on_cap(a, upper, *region.polygon, CapNormal::OF_POLYGON, margin, tolerance, points);
  }
}

void polygon_on_cap(const PlacedCylinder& a, bool upper, const FacePolygon& polygon,
                    CapNormal owner, double margin, double tolerance,
                    std::vector<ManifoldPoint>& points) {
  PlanarRegion disc;
  disc.normal = a.cap_normal(upper);
  disc.origin = a.cap_center(upper);
  disc.radius = a.radius;
  const bool parallel =
      (polygon.normal + disc.normal).squaredNorm() <= tolerance::parallel * tolerance::parallel;
  const Vec3 normal = owner == CapNormal::OF_CAP ? Vec3(-disc.normal) : polygon.normal;
  const auto add = [&](const Vec3& p, std::uint32_t feature_a, std::uint32_t feature_b,
                       ContactKind kind) {
    const double separation = disc.height(p) / -disc.normal.dot(normal);
    if (!(separation <= margin)) return;
    ManifoldPoint point;
    point.normal = normal;
    point.separation = separation;
    point.point_b = p;
    point.point_a = p + separation * normal;
    point.feature_a = feature_a;
    point.feature_b = feature_b;
    point.kind = parallel ? ContactKind::FACE_FACE : kind;
    point.normal_owner = owner == CapNormal::OF_CAP ? NormalOwner::A : NormalOwner::B;
    points.push_back(point);
  };
  for (int i = 0; i < polygon.size; ++i) {
    const PolygonCorner& corner = polygon.corners[i];
    const PolygonCorner& next = polygon.corners[i + 1 == polygon.size ? 0 : i + 1];
    if (disc.under(corner.point, tolerance)) {
      add(corner.point, PlacedCylinder::cap_feature(upper), corner.vertex,
          ContactKind::VERTEX_FACE);
    }
    double low = 0.0, high = 1.0;
    if (!disc.clip(corner.point, next.point, tolerance, low, high)) continue;
    const Vec3 along = next.point - corner.point;
    const double length = along.norm();
    // Numbers behind those of the rims and the side: where an edge enters and leaves the disc.
    if (low * length > tolerance && low < 1.0) {
      add(corner.point + low * along, make_feature(FeatureType::SMOOTH, 4), corner.edge,
          ContactKind::EDGE_FACE);
    }
    if ((1.0 - high) * length > tolerance && high > 0.0 && (high - low) * length > tolerance) {
      add(corner.point + high * along, make_feature(FeatureType::SMOOTH, 5), corner.edge,
          ContactKind::EDGE_FACE);
    }
  }
}

bool side_overlap(const PlacedCylinder& cylinder, const Vec3& direction, const Vec3& center,
                  const Vec3& along, double half, double tolerance, SideOverlap& found) {
  const PlacedCylinder& c = cylinder;
  if (c.part_facing(direction) != PlacedCylinder::Part::SIDE) return false;
  if (c.axis.cross(along).norm() > tolerance::parallel) return false;
  if (!c.radial(direction, found.normal)) return false;
  const double start = c.axis.dot(center - c.center), rise = c.axis.dot(along);
  const double one = (c.half - start) / rise, other = (-c.half - start) / rise;
  const double low = std::min(one, other), high = std::max(one, other);
  found.of_cylinder[0] = high < half - tolerance;
  found.of_cylinder[1] = low > tolerance - half;
  found.t[0] = found.of_cylinder[0] ? high : half;
  found.t[1] = found.of_cylinder[1] ? low : -half;
  if (!(found.t[0] - found.t[1] > tolerance)) return false;
  for (int i = 0; i < 2; ++i) {
    found.separation[i] = found.normal.dot(center + found.t[i] * along - c.center) - c.radius;
  }
  return true;
}

void add_shallower(const std::vector<ManifoldPoint>& more, double tolerance,
                   std::vector<ManifoldPoint>& points) {
  const double least = least_separation(points);
  for (const ManifoldPoint& p : more) {
    if (p.separation < least) continue;
    const bool known = std::any_of(points.begin(), points.end(), [&](const ManifoldPoint& q) {
      return (p.feature_a == q.feature_a && p.feature_b == q.feature_b) ||
             (p.point_b - q.point_b).norm() <= tolerance;
    });
    if (known) continue;
    points.push_back(p);
    points.back().kind = ContactKind::SMOOTH;
  }
}

double least_separation(const std::vector<ManifoldPoint>& points) {
  double least = std::numeric_limits<double>::infinity();
  for (const ManifoldPoint& p : points) least = std::min(least, p.separation);
  return least;
}

void mirror(std::vector<ManifoldPoint>& points) {
  for (ManifoldPoint& p : points) p = mirrored(p);
}

}  // namespace rb
