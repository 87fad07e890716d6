#include "collision/cylinder_contacts.hpp"

#include <algorithm>
#include <cmath>

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
  const double rise = a.axis.dot(region.normal);
  const bool upper = rise < 0.0;  // which cap is the lower one over the region
  const Vec3 cap = a.cap_center(upper);
  const Vec3 outward = a.across(region.normal);
  const double length = outward.norm();
  if (length <= tolerance::parallel) {
    for (int k = 0; k < PlacedCylinder::rim_points; ++k) {
      const Vec3 p = cap + a.radius * a.rim_direction(k);
      if (!region.under(p, tolerance)) continue;
      add(p, PlacedCylinder::rim_point_feature(upper, k), ContactKind::FACE_FACE);
    }
    if (region.polygon) {
      polygon_on_cap(a, upper, *region.polygon, margin, tolerance, points);
    }
    return;
  }
  const Vec3 down = outward / -length;
  const Vec3 lowest = cap + a.radius * down, other = a.cap_center(!upper) + a.radius * down;
  double low = 0.0, high = 1.0;
  if (region.clip(lowest, other, tolerance, low, high)) {
    const Vec3 along = other - lowest;
    add(low > 0.0 ? Vec3(lowest + low * along) : lowest,
        low > 0.0 ? PlacedCylinder::side_feature() : PlacedCylinder::rim_feature(upper),
        ContactKind::SMOOTH);
    if ((high - low) * 2.0 * a.half > tolerance) {
      add(high < 1.0 ? Vec3(lowest + high * along) : other,
          high < 1.0 ? make_feature(FeatureType::SMOOTH, 3) : PlacedCylinder::rim_feature(!upper),
          ContactKind::SMOOTH);
    }
  }
  if (std::abs(rise) <= tolerance::parallel) return;
  // Further points of the lower rim, all but the fixed one beside the lowest.
  int beside = 0;
  for (int k = 1; k < PlacedCylinder::rim_points; ++k) {
    if (down.dot(a.rim_direction(k)) > down.dot(a.rim_direction(beside))) beside = k;
  }
  for (int k = 0; k < PlacedCylinder::rim_points; ++k) {
    const Vec3 p = cap + a.radius * a.rim_direction(k);
    if (k == beside || !region.under(p, tolerance)) continue;
    add(p, PlacedCylinder::rim_point_feature(upper, k), ContactKind::SMOOTH);
  }
}

void polygon_on_cap(const PlacedCylinder& a, bool upper, const FacePolygon& polygon, double margin,
                    double tolerance, std::vector<ManifoldPoint>& points) {
  PlanarRegion disc;
  disc.normal = a.cap_normal(upper);
  disc.origin = a.cap_center(upper);
  disc.radius = a.radius;
  const bool parallel =
      (polygon.normal + disc.normal).squaredNorm() <= tolerance::parallel * tolerance::parallel;
  const auto add = [&](const Vec3& p, std::uint32_t feature_a, std::uint32_t feature_b,
                       ContactKind kind) {
    const double separation = disc.height(p);
    if (!(separation <= margin)) return;
    ManifoldPoint point;
    point.normal = -disc.normal;
    point.separation = separation;
    point.point_b = p;
    point.point_a = p - separation * disc.normal;
    point.feature_a = feature_a;
    point.feature_b = feature_b;
    point.kind = parallel ? ContactKind::FACE_FACE : kind;
    point.normal_owner = NormalOwner::A;
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

void mirror(std::vector<ManifoldPoint>& points) {
  for (ManifoldPoint& p : points) p = mirrored(p);
}

}  // namespace rb
