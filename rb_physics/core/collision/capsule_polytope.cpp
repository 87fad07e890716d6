// Capsule against box or hull: the capsule's axis as a segment against the polytope, then the
// radius.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "collision/closest.hpp"
#include "collision/pairs.hpp"
#include "collision/polytope.hpp"
#include "collision/rod.hpp"
#include "math/tolerances.hpp"

namespace rb {

namespace {

struct RodAxis {
  double separation = -std::numeric_limits<double>::infinity();  // of the segment, m
  Vec3 normal;                                                   // unit, toward the rod
  int face = -1, edge = -1;
};

void offer_face(const Rod& rod, const Polytope& b, int f, double preference, RodAxis& best) {
  const Vec3 n = b.normal(f);
  const double separation = b.height(f, rod.center) - std::abs(n.dot(rod.axis)) * rod.half;
  if (separation > best.separation + preference) best = {separation, n, f, -1};
}

void offer_edge(const Rod& rod, const Polytope& b, int e, double preference, RodAxis& best) {
  const HullEdge& edge = b.topology().edges[e];
  const Vec3 left = b.normal(edge.left), right = b.normal(edge.right);
  if (!(left.dot(rod.axis) * right.dot(rod.axis) < 0.0)) return;
  const Vec3 tail = b.vertex(edge.tail), along = b.vertex(edge.head) - tail;
  const Vec3 cross = rod.axis.cross(along);
  const double length = cross.norm();
  if (length <= tolerance::parallel_edges * along.norm()) return;
  Vec3 n = cross / length;
  if (n.dot(left + right) < 0.0) n = -n;
  double separation = n.dot(rod.center - tail);
  if (!(separation > best.separation + preference)) return;
  // Beside sliver faces, whose normals are rounding, an edge may seem to be met that isn't.
  separation = n.dot(rod.center - b.vertex(b.farthest(n, edge.tail)));
  if (separation > best.separation + preference) best = {separation, n, -1, e};
}

// Over all faces and edges, or when apart over those at the vertex nearest the rod.
RodAxis separating_axis(const Rod& rod, const Polytope& b, bool apart, int vertex,
                        double preference) {
  RodAxis best;
  if (apart) {
    b.for_each_face_at(vertex, [&](int f) { offer_face(rod, b, f, preference, best); });
    b.for_each_edge_at(vertex, [&](int e) { offer_edge(rod, b, e, preference, best); });
    return best;
  }
  for (int f = 0; f < b.face_count(); ++f) offer_face(rod, b, f, preference, best);
  const int edges = static_cast<int>(b.topology().edges.size());
  for (int e = 0; e < edges; ++e) offer_edge(rod, b, e, preference, best);
  return best;
}

// Where the rod is met already.
struct Met {
  double along, separation;  // m, from its middle; of the segment
};

// The part of the rod over a face: its two ends, but for one that is met already or lies deeper.
void face_contacts(const Rod& rod, const Polytope& b, int of_face, double margin, double tolerance,
                   Manifold& out, const Met* met = nullptr) {
  static thread_local std::vector<PolygonCorner> corners;
  const FacePolygon face = b.polygon(of_face, corners);
  double low = -rod.half, high = rod.half;
  std::uint32_t low_edge = face.face, high_edge = face.face;
  for (int i = 0; i < face.size; ++i) {
    const Vec3& corner = corners[i].point;
    const Vec3& next = corners[i + 1 == face.size ? 0 : i + 1].point;
    const Vec3 outward = (next - corner).cross(face.normal).normalized();
    const double start = outward.dot(rod.center - corner), slope = outward.dot(rod.axis);
    if (start - std::abs(slope) * rod.half > tolerance) return;  // all of it beyond this edge
    if (start + std::abs(slope) * rod.half <= tolerance) continue;
    const double crossing = -start / slope;
    if (slope > 0.0 && crossing < high) {
      high = crossing;
      high_edge = corners[i].edge;
    } else if (slope < 0.0 && crossing > low) {
      low = crossing;
      low_edge = corners[i].edge;
    }
  }
  if (low > high + tolerance) return;
  const auto add = [&](double along, std::uint32_t feature) {
    const double separation =
        face.normal.dot(rod.center + along * rod.axis - face.corners[0].point);
    if (met && (std::abs(along - met->along) <= tolerance || separation < met->separation)) return;
    if (!(separation - rod.radius <= margin)) return;
    ManifoldPoint p = rod.contact(along, face.normal, separation);
    p.feature_b = feature;
    p.normal_owner = NormalOwner::B;
    out.add(p);
  };
  add(high, high_edge);
  if (high - low > tolerance) add(low, low_edge);
}

// A rod that is met between its ends and lies nearly flat on a face beside: its end there is next
// to touch.
struct FlatFace {
  double cosine = 0.98;  // of the angle between its normal and that of the contact
  int face = -1;

  void offer(const Polytope& b, int f, const Vec3& normal) {
    const double c = b.normal(f).dot(normal);
    if (c > cosine) cosine = c, face = f;
  }
};

bool edge_contact(const Rod& rod, const Polytope& b, const RodAxis& axis, double margin,
                  double tolerance, Manifold& out) {
  const HullEdge& edge = b.topology().edges[axis.edge];
  const Vec3 tail = b.vertex(edge.tail);
  const Vec3 along = b.vertex(edge.head) - tail;
  const double length = along.norm();
  const Vec3 unit = along / length;
  Vec3 on_rod, on_edge;
  closest_on_lines(rod.center, rod.axis, tail, unit, on_rod, on_edge);
  const double s = rod.axis.dot(on_rod - rod.center), t = unit.dot(on_edge - tail);
  ManifoldPoint p = rod.contact(s, axis.normal, axis.separation);
  p.point_b = on_edge;
  p.feature_a = make_feature(FeatureType::SMOOTH, 2);
  p.feature_b = b.edge_feature(axis.edge);
  p.normal_owner = NormalOwner::EDGES;
  out.add(p);
  if (!(std::abs(s) <= rod.half + tolerance && t >= -tolerance && t <= length + tolerance))
    return false;
  FlatFace flat;
  for (const int face : {edge.left, edge.right}) flat.offer(b, face, axis.normal);
  const Met met{s, axis.separation};
  if (flat.face >= 0) face_contacts(rod, b, flat.face, margin, tolerance, out, &met);
  return true;
}

// Where the nearest features are a vertex, or an edge with the rod beside it.
void nearest_contact(const Rod& rod, const Polytope& b, const GjkResult& nearest, double margin,
                     double tolerance, Manifold& out) {
  if (!(nearest.distance - rod.radius <= margin)) return;
  const Simplex& s = nearest.simplex;
  int vertices[4];
  for (int i = 0; i < s.size; ++i) vertices[i] = s.vertex[i].index_b;
  const std::uint32_t feature = b.feature_of(vertices, s.size);
  const Vec3 normal = nearest.toward_a / nearest.distance;
  if (feature_type(feature) == FeatureType::EDGE) {
    const HullEdge& edge = b.topology().edges[feature_index(feature)];
    const Vec3 along = b.vertex(edge.head) - b.vertex(edge.tail);
    const double half = 0.5 * along.norm();
    const Vec3 unit = along / (2.0 * half);
    if (rod.axis.cross(unit).squaredNorm() <= tolerance::parallel * tolerance::parallel) {
      const double middle =
          rod.axis.dot(0.5 * (b.vertex(edge.head) + b.vertex(edge.tail)) - rod.center);
      const double low = std::max(-rod.half, middle - half),
                   high = std::min(rod.half, middle + half);
      if (high - low > tolerance::coincident * b.size()) {
        for (const double at : {high, low}) {
          ManifoldPoint p = rod.contact(at, normal, nearest.distance);
          p.feature_b = std::abs(at) == rod.half
                            ? feature
                            : make_feature(FeatureType::VERTEX,
                                           (at == high) == (unit.dot(rod.axis) > 0.0) ? edge.head
                                                                                      : edge.tail);
          out.add(p);
        }
        return;
      }
    }
  }
  const Vec3 on_rod = s.nearest_on_a();
  bool ends[2] = {false, false};
  for (int i = 0; i < s.size; ++i) ends[s.vertex[i].index_a] = true;
  ManifoldPoint p;
  p.normal = normal;
  p.separation = nearest.distance - rod.radius;
  p.point_a = on_rod - rod.radius * normal;
  p.point_b = s.nearest_on_b();
  p.feature_a = make_feature(FeatureType::SMOOTH, ends[0] && ends[1] ? 2 : ends[0] ? 0 : 1);
  p.feature_b = feature;
  out.add(p);
  if (!(ends[0] && ends[1])) return;
  FlatFace flat;
  if (feature_type(feature) == FeatureType::EDGE) {
    const HullEdge& edge = b.topology().edges[feature_index(feature)];
    for (const int face : {edge.left, edge.right}) flat.offer(b, face, normal);
  } else if (feature_type(feature) == FeatureType::VERTEX) {
    b.for_each_face_at(vertices[0], [&](int face) { flat.offer(b, face, normal); });
  }
  const Met met{rod.axis.dot(on_rod - rod.center), nearest.distance};
  if (flat.face >= 0) face_contacts(rod, b, flat.face, margin, tolerance, out, &met);
}

// The deepest end alone, should rounding leave nothing over the face.
void deepest_contact(const Rod& rod, const Polytope& b, const RodAxis& axis, Manifold& out) {
  const double along = axis.normal.dot(rod.axis) > 0.0 ? -rod.half : rod.half;
  const std::uint32_t face = make_feature(FeatureType::FACE, axis.face);
  ManifoldPoint p = rod.contact(along, axis.normal, axis.separation);
  p.feature_b = axis.face >= 0 ? face : b.edge_feature(axis.edge);
  p.normal_owner = NormalOwner::B;
  out.add(p);
}

void contacts(const Capsule& a, const Placement& at_a, const Polytope& b, double margin,
              Manifold& out) {
  const Rod rod(a, at_a);
  const double size_a = a.radius + a.half_length;
  const double small = std::min(size_a, b.size()), large = std::max(size_a, b.size());
  const double tolerance = tolerance::coincident * small + 1e-14 * large;
  const double close = tolerance::closest_direction * small;
  const GjkResult nearest =
      gjk(rod, b, Vec3(rod.center - b.center()), margin + rod.radius, 0.01 * close);
  if (nearest.status == GjkStatus::BEYOND) return;
  const bool apart = nearest.status != GjkStatus::OVERLAP && nearest.distance > close;
  const RodAxis axis = separating_axis(rod, b, apart, nearest.simplex.vertex[0].index_b,
                                       tolerance::axis_preference * small);
  const int first = out.size();
  if (!apart || nearest.distance <= axis.separation + tolerance) {
    if (!(axis.separation - rod.radius <= margin)) return;
    if (axis.edge >= 0) {
      if (edge_contact(rod, b, axis, margin, tolerance, out)) return;
    } else {
      face_contacts(rod, b, axis.face, margin, tolerance, out);
      if (out.least_separation(first) <= axis.separation - rod.radius + tolerance) return;
    }
    if (!apart) {
      if (out.size() == first) deepest_contact(rod, b, axis, out);
      return;
    }
  }
  out.truncate(first);
  nearest_contact(rod, b, nearest, margin, tolerance, out);
}

}  // namespace

void contacts_capsule_box(const Capsule& a, const Placement& at_a, const Box& b,
                          const Placement& at_b, double margin, Manifold& out) {
  contacts(a, at_a, placed_polytope(b, at_b), margin, out);
}

void contacts_capsule_hull(const Capsule& a, const Placement& at_a, const ConvexHull& b,
                           const Placement& at_b, double margin, Manifold& out) {
  contacts(a, at_a, placed_polytope(b, at_b), margin, out);
}

}  // namespace rb
