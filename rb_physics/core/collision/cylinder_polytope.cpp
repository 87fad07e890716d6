// Cylinder against box or hull.
#include <algorithm>
#include <cmath>
#include <vector>

#include "collision/closest.hpp"
#include "collision/convex_axis.hpp"
#include "collision/cylinder_contacts.hpp"
#include "collision/pairs.hpp"
#include "collision/polytope.hpp"
#include "collision/reduce.hpp"

namespace rb {

namespace {

constexpr int few_faces = 12;  // up to so many, every face is tried

// Calls visit(other vertex, vector to it) for the edges at a vertex.
template <class Visit>
void for_each_edge_from(const Polytope& b, int vertex, const Visit& visit) {
  const HullData& hull = b.topology();
  for (int i = hull.neighbor_first[vertex]; i < hull.neighbor_first[vertex + 1]; ++i) {
    visit(hull.neighbors[i], b.vertex(hull.neighbors[i]) - b.vertex(vertex));
  }
}

ConvexAxis find_axis(const PlacedCylinder& a, const Polytope& b, double size, double margin) {
  const AxisSearch search(a, b, size);
  ConvexAxis axis = search.first(a.center - b.center(), margin);
  if (axis.beyond) return axis;
  const HullData& hull = b.topology();
  const Vec3 first = axis.normal;
  const int vertex = b.farthest(first);
  const auto refine = [&] {
    for_each_edge_from(b, vertex, [&](int, const Vec3& edge) { search.refine_across(edge, axis); });
    search.refine_across(a.axis, axis);
    search.refine(axis);
  };
  if (axis.apart && !axis.certain) refine();
  if (b.face_count() <= few_faces) {
    for (int f = 0; f < b.face_count(); ++f) search.offer(b.normal(f), axis);
  } else {
    for (int i = hull.face_first[vertex]; i < hull.face_first[vertex + 1]; ++i) {
      search.offer(b.normal(hull.faces_at[i]), axis);
    }
  }
  search.offer(a.axis.dot(first) >= 0.0 ? a.axis : Vec3(-a.axis), axis);
  for_each_edge_from(b, vertex, [&](int, const Vec3& edge) {
    const Vec3 cross = a.axis.cross(edge);
    const double length = cross.norm();
    if (length <= tolerance::parallel_edges * edge.norm()) return;
    search.offer(cross.dot(first) >= 0.0 ? Vec3(cross / length) : Vec3(-cross / length), axis);
  });
  if (!axis.fixed && !axis.apart) refine();
  return axis;
}

// The vertex or edge of B that looks along the normal.
std::uint32_t facing_feature(const Polytope& b, const Vec3& normal, int vertex, Vec3& along) {
  std::uint32_t feature = make_feature(FeatureType::VERTEX, vertex);
  along = Vec3::Zero();
  double least_slope = tolerance::parallel;
  for_each_edge_from(b, vertex, [&](int other, const Vec3& edge) {
    const double slope = std::abs(normal.dot(edge)) / edge.norm();
    if (!(slope <= least_slope)) return;
    least_slope = slope;
    const int ends[2] = {vertex, other};
    feature = b.feature_of(ends, 2);
    along = edge;
  });
  return feature;
}

void side_contacts(const PlacedCylinder& a, const Polytope& b, const ConvexAxis& axis, int vertex,
                   double tolerance, std::vector<ManifoldPoint>& points) {
  Vec3 edge;
  ManifoldPoint p;
  p.normal = axis.normal;
  p.separation = axis.separation;
  p.feature_a = PlacedCylinder::side_feature();
  p.feature_b = facing_feature(b, axis.normal, vertex, edge);
  const double length = edge.norm();
  const Vec3 to_side = -a.radius * axis.normal;
  const Vec3& corner = b.vertex(vertex);
  if (length > 0.0 && a.axis.cross(edge).norm() > tolerance::parallel * length) {
    Vec3 on_axis;
    closest_on_lines(a.center, a.axis, corner, edge / length, on_axis, p.point_b);
    p.point_a = on_axis + to_side;
    p.normal_owner = NormalOwner::EDGES;
    points.push_back(p);
    return;
  }
  if (length > 0.0) {
    // Side by side: both ends of the common part.
    const double from = a.axis.dot(corner - a.center), to = from + a.axis.dot(edge);
    const double low = std::max(-a.half, std::min(from, to));
    const double high = std::min(a.half, std::max(from, to));
    if (high - low > tolerance) {
      for (const double at : {high, low}) {
        p.point_a = a.center + at * a.axis + to_side;
        p.point_b = p.point_a - axis.separation * axis.normal;
        p.feature_a = std::abs(at) == a.half
                          ? PlacedCylinder::rim_feature(at > 0.0)
                          : make_feature(FeatureType::SMOOTH, at == high ? 2 : 3);
        points.push_back(p);
      }
      return;
    }
  }
  p.point_b = corner;
  p.point_a = corner + axis.separation * axis.normal;
  points.push_back(p);
}

void contacts(const Cylinder& shape, const Placement& at, const Polytope& b, double margin,
              Manifold& out) {
  static thread_local std::vector<ManifoldPoint> points;
  static thread_local std::vector<PolygonCorner> corners;
  const PlacedCylinder a(shape, at);
  const double small = std::min(a.size(), b.size()), large = std::max(a.size(), b.size());
  const double tolerance = tolerance::coincident * small + 1e-14 * large;
  const ConvexAxis axis = find_axis(a, b, small, margin);
  if (axis.beyond || !(axis.separation <= margin)) return;
  points.clear();
  const Vec3& n = axis.normal;
  const int vertex = b.farthest(n);
  const int face = b.opposing_face(-n, vertex);
  const FacePolygon polygon = b.polygon(face, corners);
  const PlacedCylinder::Part part = a.part_facing(-n);
  const bool on_face =
      (polygon.normal - n).squaredNorm() <= tolerance::parallel * tolerance::parallel;
  if (on_face) {
    PlanarRegion region{polygon.normal, corners[0].point, polygon.face, &polygon, 0.0};
    cylinder_on_region(a, region, margin, tolerance, points);
  } else if (part == PlacedCylinder::Part::CAP) {
    polygon_on_cap(a, a.axis.dot(n) < 0.0, polygon, margin, tolerance, points);
  } else if (part == PlacedCylinder::Part::SIDE) {
    side_contacts(a, b, axis, vertex, tolerance, points);
  }
  double least = std::numeric_limits<double>::infinity();
  for (const ManifoldPoint& p : points) least = std::min(least, p.separation);
  if (least > axis.separation + tolerance) {
    // Rim against edge or corner, and whatever the cases above left out: one point.
    points.clear();
    Vec3 edge;
    ManifoldPoint p;
    p.normal = n;
    p.separation = axis.separation;
    if (axis.certain && !axis.fixed) {
      p.point_a = axis.on_a;
      p.point_b = axis.on_b;
    } else {
      p.point_a = a(Vec3(-n)).point;
      p.point_b = p.point_a - axis.separation * n;
    }
    p.feature_a = part == PlacedCylinder::Part::SIDE
                      ? PlacedCylinder::side_feature()
                      : PlacedCylinder::rim_feature(a.axis.dot(n) < 0.0);
    p.feature_b = facing_feature(b, n, vertex, edge);
    points.push_back(p);
  }
  reduce_cloud(points, n, out);
}

}  // namespace

void contacts_cylinder_box(const Cylinder& a, const Placement& at_a, const Box& b,
                           const Placement& at_b, double margin, Manifold& out) {
  static thread_local Polytope polytope;
  polytope.place(b, at_b);
  contacts(a, at_a, polytope, margin, out);
}

void contacts_cylinder_hull(const Cylinder& a, const Placement& at_a, const ConvexHull& b,
                            const Placement& at_b, double margin, Manifold& out) {
  static thread_local Polytope polytope;
  polytope.place(b, at_b);
  contacts(a, at_a, polytope, margin, out);
}

}  // namespace rb
