#include "collision/polytope_polytope.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "collision/closest.hpp"
#include "collision/face_clip.hpp"
#include "collision/pairs.hpp"
#include "math/tolerances.hpp"

namespace rb {

namespace {

struct Scale {
  double small;      // m, size of the smaller polytope
  double tolerance;  // m, lengths below are zero when features are named
};

Scale scale_of(const Polytope& a, const Polytope& b) {
  const double small = std::min(a.size(), b.size()), large = std::max(a.size(), b.size());
  return {small, tolerance::coincident * small + 1e-14 * large};
}

void face_contacts(const Polytope& a, const Polytope& b, const PolytopeAxis& axis, double margin,
                   double tolerance, Manifold& out) {
  static thread_local std::vector<PolygonCorner> reference_corners, incident_corners;
  const bool reference_is_b = axis.kind == PolytopeAxis::FACE_B;
  const Polytope& reference = reference_is_b ? b : a;
  const Polytope& incident = reference_is_b ? a : b;
  const FacePolygon face =
      reference.polygon(reference_is_b ? axis.feature_b : axis.feature_a, reference_corners);
  const int lowest = incident.farthest(-face.normal);
  const FacePolygon facing =
      incident.polygon(incident.opposing_face(face.normal, lowest), incident_corners);
  clip_faces(face, facing, reference_is_b, margin, tolerance, out);
}

// Adds the crossing of two edges. False: they pass beside each other.
bool edge_contact(const Polytope& a, const Polytope& b, const PolytopeAxis& axis, double tolerance,
                  Manifold& out) {
  const HullEdge& edge_a = a.topology().edges[axis.feature_a];
  const HullEdge& edge_b = b.topology().edges[axis.feature_b];
  const Vec3 along_a = a.vertex(edge_a.head) - a.vertex(edge_a.tail);
  const Vec3 along_b = b.vertex(edge_b.head) - b.vertex(edge_b.tail);
  const double length_a = along_a.norm(), length_b = along_b.norm();
  const Vec3 unit_a = along_a / length_a, unit_b = along_b / length_b;
  ManifoldPoint p;
  closest_on_lines(a.vertex(edge_a.tail), unit_a, b.vertex(edge_b.tail), unit_b, p.point_a,
                   p.point_b);
  p.normal = axis.normal;
  p.separation = axis.separation;
  p.feature_a = a.edge_feature(axis.feature_a);
  p.feature_b = b.edge_feature(axis.feature_b);
  p.kind = ContactKind::EDGE_EDGE;
  p.normal_owner = NormalOwner::EDGES;
  out.add(p);
  const double at_a = unit_a.dot(p.point_a - a.vertex(edge_a.tail));
  const double at_b = unit_b.dot(p.point_b - b.vertex(edge_b.tail));
  return std::min(at_a, at_b) >= -tolerance && at_a <= length_a + tolerance &&
         at_b <= length_b + tolerance;
}

// The deepest vertex alone, should rounding leave nothing over the face.
void deepest_contact(const Polytope& a, const Polytope& b, const PolytopeAxis& axis,
                     Manifold& out) {
  const bool reference_is_b = axis.kind == PolytopeAxis::FACE_B;
  ManifoldPoint p;
  p.normal = axis.normal;
  p.separation = axis.separation;
  p.kind = ContactKind::VERTEX_FACE;
  if (reference_is_b) {
    const int vertex = a.farthest(-axis.normal);
    p.point_a = a.vertex(vertex);
    p.point_b = p.point_a - axis.separation * axis.normal;
    p.feature_a = make_feature(FeatureType::VERTEX, vertex);
    p.feature_b = make_feature(FeatureType::FACE, axis.feature_b);
    p.normal_owner = NormalOwner::B;
  } else {
    const int vertex = b.farthest(axis.normal);
    p.point_b = b.vertex(vertex);
    p.point_a = p.point_b + axis.separation * axis.normal;
    p.feature_a = make_feature(FeatureType::FACE, axis.feature_a);
    p.feature_b = make_feature(FeatureType::VERTEX, vertex);
    p.normal_owner = NormalOwner::A;
  }
  out.add(p);
}

// The one pair of nearest points of polytopes that are apart.
void nearest_contact(const Polytope& a, const Polytope& b, double margin, const GjkResult& nearest,
                     Manifold& out) {
  if (!(nearest.distance <= margin)) return;
  const Simplex& s = nearest.simplex;
  int vertices_a[4], vertices_b[4];
  for (int i = 0; i < s.size; ++i) {
    vertices_a[i] = s.vertex[i].index_a;
    vertices_b[i] = s.vertex[i].index_b;
  }
  ManifoldPoint p;
  p.point_a = s.nearest_on_a();
  p.point_b = s.nearest_on_b();
  p.normal = nearest.toward_a / nearest.distance;
  p.separation = nearest.distance;
  p.feature_a = a.feature_of(vertices_a, s.size);
  p.feature_b = b.feature_of(vertices_b, s.size);
  p.kind = ContactKind::VERTEX_FACE;
  out.add(p);
}

}  // namespace

void contacts_polytopes(const Polytope& a, const Polytope& b, double margin, Manifold& out) {
  const Scale scale = scale_of(a, b);
  const double close = tolerance::closest_direction * scale.small;
  const GjkResult nearest = gjk(a, b, Vec3(a.center() - b.center()), margin, 0.01 * close);
  if (nearest.status == GjkStatus::BEYOND) return;
  const bool apart = nearest.status != GjkStatus::OVERLAP && nearest.distance > close;
  if (apart && nearest.distance > margin) return;
  const PolytopeAxis axis = separating_axis(a, b, tolerance::axis_preference * scale.small);
  if (axis.separation > margin) return;
  const int first = out.size();
  if (!apart || nearest.distance <= axis.separation + scale.tolerance) {
    if (axis.kind == PolytopeAxis::EDGES) {
      if (edge_contact(a, b, axis, scale.tolerance, out)) return;
    } else {
      face_contacts(a, b, axis, margin, scale.tolerance, out);
      if (out.least_separation(first) <= axis.separation + scale.tolerance) return;
    }
    if (!apart) {
      if (out.size() == first) deepest_contact(a, b, axis, out);
      return;
    }
  }
  out.truncate(first);
  nearest_contact(a, b, margin, nearest, out);
}

void contacts_box_hull(const Box& a, const Placement& at_a, const ConvexHull& b,
                       const Placement& at_b, double margin, Manifold& out) {
  static thread_local Polytope polytope_a, polytope_b;
  polytope_a.place(a, at_a);
  polytope_b.place(b, at_b);
  contacts_polytopes(polytope_a, polytope_b, margin, out);
}

void contacts_hull_hull(const ConvexHull& a, const Placement& at_a, const ConvexHull& b,
                        const Placement& at_b, double margin, Manifold& out) {
  static thread_local Polytope polytope_a, polytope_b;
  polytope_a.place(a, at_a);
  polytope_b.place(b, at_b);
  contacts_polytopes(polytope_a, polytope_b, margin, out);
}

}  // namespace rb
