#include "collision/polytope_polytope.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "collision/closest.hpp"
#include "collision/convex_axis.hpp"
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

// The corners of the facing faces of polytopes that lie nearly flat on each other and meet edge to
// edge.
void flat_contacts(const Polytope& a, const Polytope& b, const Vec3& normal, double margin,
                   const Scale& scale, Manifold& out) {
  const int face_a = a.opposing_face(normal, a.farthest(-normal));
  const int face_b = b.opposing_face(-normal, b.farthest(normal));
  const double cosine_a = -normal.dot(a.normal(face_a)), cosine_b = normal.dot(b.normal(face_b));
  if (std::max(cosine_a, cosine_b) < flat_cosine) return;
  PolytopeAxis axis;
  axis.kind = cosine_b >= cosine_a ? PolytopeAxis::FACE_B : PolytopeAxis::FACE_A;
  axis.feature_a = face_a;
  axis.feature_b = face_b;
  Manifold corners;
  face_contacts(a, b, axis, margin, scale.tolerance, corners);
  add_beside_crossing(corners, normal, scale.small, out);
}

// The deepest vertex, should rounding leave it beside the face.
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

// The vertex or edge of `p` that looks along `direction`.
std::uint32_t facing_feature(const Polytope& p, const Vec3& direction) {
  const int vertex = p.farthest(direction);
  std::uint32_t feature = make_feature(FeatureType::VERTEX, vertex);
  p.for_each_edge_at(vertex, [&](int e) {
    const HullEdge& edge = p.topology().edges[e];
    const Vec3 along = p.vertex(edge.head) - p.vertex(edge.tail);
    if (std::abs(direction.dot(along)) <= tolerance::parallel * along.norm()) {
      feature = p.edge_feature(e);
    }
  });
  return feature;
}

// The one pair of nearest points of polytopes that are apart, corner to corner or corner to edge.
void nearest_contact(const Polytope& a, const Polytope& b, const ConvexAxis& nearest,
                     Manifold& out) {
  ManifoldPoint p;
  p.point_a = nearest.on_a;
  p.point_b = nearest.on_b;
  p.normal = nearest.normal;
  p.separation = nearest.normal.dot(nearest.on_a - nearest.on_b);
  p.feature_a = facing_feature(a, -nearest.normal);
  p.feature_b = facing_feature(b, nearest.normal);
  p.kind = ContactKind::VERTEX_FACE;
  out.add(p);
}

// Among the faces and pairs of edges that look along `normal`, an axis whose separation is not less
// than the one known by more than `preference`; its separation is -infinity when there is none.
PolytopeAxis local_axis(const Polytope& a, const Polytope& b, const Vec3& normal, double separation,
                        double preference) {
  constexpr double face_cosine = 0.9, edge_slope = 0.01;  // rough: the separation decides
  PolytopeAxis best;
  best.separation = -std::numeric_limits<double>::infinity();
  const auto wins = [&](double s) {
    return s >= separation - preference && s > best.separation + preference;
  };
  const int vertex_a = a.farthest(-normal), vertex_b = b.farthest(normal);
  const Vec3 on_a = a.vertex(vertex_a), on_b = b.vertex(vertex_b);
  // Along n the two are no farther apart than these two points.
  const auto may_win = [&](const Vec3& n) { return n.dot(on_a - on_b) >= separation - preference; };
  b.for_each_face_at(vertex_b, [&](int f) {
    const Vec3 n = b.normal(f);
    if (n.dot(normal) < face_cosine || !may_win(n)) return;
    const double s = b.height(f, a.vertex(a.farthest(-n, vertex_a)));
    if (wins(s)) best = {PolytopeAxis::FACE_B, s, n, 0, f};
  });
  a.for_each_face_at(vertex_a, [&](int f) {
    const Vec3 n = -a.normal(f);
    if (n.dot(normal) < face_cosine || !may_win(n)) return;
    const double s = a.height(f, b.vertex(b.farthest(n, vertex_b)));
    if (wins(s)) best = {PolytopeAxis::FACE_A, s, n, f, 0};
  });
  if (best.separation > -std::numeric_limits<double>::infinity()) return best;
  a.for_each_edge_at(vertex_a, [&](int ea) {
    const HullEdge& edge_a = a.topology().edges[ea];
    const Vec3 along_a = a.vertex(edge_a.head) - a.vertex(edge_a.tail);
    if (std::abs(normal.dot(along_a)) > edge_slope * along_a.norm()) return;
    b.for_each_edge_at(vertex_b, [&](int eb) {
      const HullEdge& edge_b = b.topology().edges[eb];
      const Vec3 along_b = b.vertex(edge_b.head) - b.vertex(edge_b.tail);
      if (std::abs(normal.dot(along_b)) > edge_slope * along_b.norm()) return;
      const Vec3 cross = along_a.cross(along_b);
      const double length = cross.norm();
      if (length <= tolerance::parallel_edges * along_a.norm() * along_b.norm()) return;
      const Vec3 n = cross.dot(normal) > 0.0 ? Vec3(cross / length) : Vec3(-cross / length);
      if (!may_win(n)) return;
      const double s =
          n.dot(a.vertex(a.farthest(-n, vertex_a)) - b.vertex(b.farthest(n, vertex_b)));
      // Both edges must be the farthest there are.
      if (s < n.dot(on_a - on_b) - preference) return;
      if (wins(s)) best = {PolytopeAxis::EDGES, s, n, ea, eb};
    });
  });
  return best;
}

}  // namespace

void contacts_polytopes(const Polytope& a, const Polytope& b, double margin, Manifold& out) {
  const Scale scale = scale_of(a, b);
  const AxisSearch search(a, b, scale.small);
  const ConvexAxis nearest = search.first(a.center() - b.center(), margin);
  if (nearest.beyond || (nearest.apart && nearest.separation > margin)) return;
  const double preference = tolerance::axis_preference * scale.small;
  PolytopeAxis axis = local_axis(a, b, nearest.normal, nearest.separation, preference);
  const bool known = nearest.least && axis.separation >= nearest.separation - preference;
  if (!nearest.apart && !known) axis = separating_axis(a, b, preference);
  const int first = out.size();
  if (known || !nearest.apart) {
    if (axis.separation > margin) return;
    if (axis.kind == PolytopeAxis::EDGES) {
      if (edge_contact(a, b, axis, scale.tolerance, out)) {
        flat_contacts(a, b, axis.normal, margin, scale, out);
        return;
      }
    } else {
      face_contacts(a, b, axis, margin, scale.tolerance, out);
      if (out.least_separation(first) <= axis.separation + scale.tolerance) return;
    }
    if (!nearest.apart) {
      if (axis.kind == PolytopeAxis::EDGES) return;
      if (out.size() == Manifold::capacity) out.truncate(first);
      deepest_contact(a, b, axis, out);
      return;
    }
  }
  out.truncate(first);
  nearest_contact(a, b, nearest, out);
}

void contacts_box_hull(const Box& a, const Placement& at_a, const ConvexHull& b,
                       const Placement& at_b, double margin, Manifold& out) {
  contacts_polytopes(placed_polytope(a, at_a), placed_polytope(b, at_b), margin, out);
}

void contacts_hull_hull(const ConvexHull& a, const Placement& at_a, const ConvexHull& b,
                        const Placement& at_b, double margin, Manifold& out) {
  static thread_local Polytope polytope_a, polytope_b;
  polytope_a.place(a, at_a);
  polytope_b.place(b, at_b);
  contacts_polytopes(polytope_a, polytope_b, margin, out);
}

}  // namespace rb
