// Box against box: separating axis test over 15 axes (Gottschalk et al. 1996), then face clipping
// or the closest points of two edges.
#include "collision/box_box.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collision/box_features.hpp"
#include "collision/closest.hpp"
#include "collision/face_clip.hpp"
#include "collision/pairs.hpp"
#include "math/tolerances.hpp"

namespace rb {

namespace {

double size_of(const Box& box) { return box.half_extents.maxCoeff(); }

// The face of `box` that looks most against `normal`; the lowest index decides a tie.
int opposing_face(const Placement& at, const Vec3& normal) {
  const Vec3 d = at.rotation.transpose() * normal;
  int axis = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::abs(d[i]) > std::abs(d[axis]) + tolerance::coincident) axis = i;
  }
  return 2 * axis + (d[axis] < 0.0 ? 1 : 0);
}

// Adds the crossing of the two edges that look at each other. False: they pass beside each other.
bool edge_edge_contact(const Box& a, const Placement& at_a, const Box& b, const Placement& at_b,
                       const BoxAxis& axis, double tolerance, Manifold& out) {
  const int corner_a = BoxSupport{a, at_a}(-axis.normal).index;
  const int corner_b = BoxSupport{b, at_b}(axis.normal).index;
  const Vec3 on_a = at_a.apply(box_corner(a, corner_a)), on_b = at_b.apply(box_corner(b, corner_b));
  const Vec3 along_a = at_a.rotation.col(axis.edge_a), along_b = at_b.rotation.col(axis.edge_b);
  ManifoldPoint p;
  closest_on_lines(on_a, along_a, on_b, along_b, p.point_a, p.point_b);
  p.normal = axis.normal;
  p.separation = axis.separation;
  p.feature_a = make_feature(FeatureType::EDGE, box_edge_index(axis.edge_a, corner_a));
  p.feature_b = make_feature(FeatureType::EDGE, box_edge_index(axis.edge_b, corner_b));
  p.kind = ContactKind::EDGE_EDGE;
  p.normal_owner = NormalOwner::EDGES;
  out.add(p);
  const double beyond_a =
      std::abs(along_a.dot(p.point_a - at_a.position)) - a.half_extents[axis.edge_a];
  const double beyond_b =
      std::abs(along_b.dot(p.point_b - at_b.position)) - b.half_extents[axis.edge_b];
  return std::max(beyond_a, beyond_b) <= tolerance;
}

void face_contacts(const Box& a, const Placement& at_a, const Box& b, const Placement& at_b,
                   const BoxAxis& axis, double margin, double tolerance, Manifold& out) {
  const bool reference_is_b = axis.kind == BoxAxis::FACE_B;
  const Box& reference_box = reference_is_b ? b : a;
  const Placement& reference_at = reference_is_b ? at_b : at_a;
  const Box& incident_box = reference_is_b ? a : b;
  const Placement& incident_at = reference_is_b ? at_a : at_b;
  std::array<PolygonCorner, 4> reference_corners, incident_corners;
  const FacePolygon reference = box_face(reference_box, reference_at, axis.face, reference_corners);
  const FacePolygon incident = box_face(
      incident_box, incident_at, opposing_face(incident_at, reference.normal), incident_corners);
  clip_faces(reference, incident, reference_is_b, margin, tolerance, out);
}

// The corners of the facing faces of boxes that lie nearly flat on each other and meet edge to
// edge.
void flat_contacts(const Box& a, const Placement& at_a, const Box& b, const Placement& at_b,
                   const Vec3& normal, double margin, double tolerance, Manifold& out) {
  const Vec3 in_a = at_a.rotation.transpose() * normal, in_b = at_b.rotation.transpose() * normal;
  Eigen::Index axis_a, axis_b;
  const double cosine_a = in_a.cwiseAbs().maxCoeff(&axis_a);
  const double cosine_b = in_b.cwiseAbs().maxCoeff(&axis_b);
  if (std::max(cosine_a, cosine_b) < flat_cosine) return;
  BoxAxis axis;
  if (cosine_b >= cosine_a) {
    axis.kind = BoxAxis::FACE_B;
    axis.face = 2 * static_cast<int>(axis_b) + (in_b[axis_b] > 0.0 ? 1 : 0);
  } else {
    axis.kind = BoxAxis::FACE_A;
    axis.face = 2 * static_cast<int>(axis_a) + (in_a[axis_a] > 0.0 ? 0 : 1);
  }
  Manifold corners;
  face_contacts(a, at_a, b, at_b, axis, margin, tolerance, corners);
  add_beside_crossing(corners, normal, std::min(size_of(a), size_of(b)), out);
}

// The deepest corner alone, should rounding leave nothing over the face.
void deepest_contact(const Box& a, const Placement& at_a, const Box& b, const Placement& at_b,
                     const BoxAxis& axis, Manifold& out) {
  const std::uint32_t face = make_feature(FeatureType::FACE, axis.face);
  ManifoldPoint p;
  p.normal = axis.normal;
  p.separation = axis.separation;
  p.kind = ContactKind::VERTEX_FACE;
  if (axis.kind == BoxAxis::FACE_B) {
    const SupportPoint corner = BoxSupport{a, at_a}(-axis.normal);
    p.point_a = corner.point;
    p.point_b = corner.point - axis.separation * axis.normal;
    p.feature_a = make_feature(FeatureType::VERTEX, corner.index);
    p.feature_b = face;
    p.normal_owner = NormalOwner::B;
  } else {
    const SupportPoint corner = BoxSupport{b, at_b}(axis.normal);
    p.point_b = corner.point;
    p.point_a = corner.point + axis.separation * axis.normal;
    p.feature_a = face;
    p.feature_b = make_feature(FeatureType::VERTEX, corner.index);
    p.normal_owner = NormalOwner::A;
  }
  out.add(p);
}

// Nearest points of separated boxes that meet corner to corner or corner to edge.
void nearest_contact(double margin, const GjkResult& nearest, Manifold& out) {
  if (!(nearest.distance <= margin)) return;
  const auto named = [](const Simplex& simplex, int SimplexVertex::*index) {
    int free_bits = 0;
    for (int i = 1; i < simplex.size; ++i) {
      free_bits |= simplex.vertex[i].*index ^ simplex.vertex[0].*index;
    }
    return box_feature(simplex.vertex[0].*index, free_bits);
  };
  ManifoldPoint p;
  p.point_a = nearest.simplex.nearest_on_a();
  p.point_b = nearest.simplex.nearest_on_b();
  p.normal = nearest.toward_a / nearest.distance;
  p.separation = nearest.distance;
  p.feature_a = named(nearest.simplex, &SimplexVertex::index_a);
  p.feature_b = named(nearest.simplex, &SimplexVertex::index_b);
  p.kind = ContactKind::VERTEX_FACE;
  out.add(p);
}

}  // namespace

BoxAxis separating_axis(const Box& a, const Placement& at_a, const Box& b, const Placement& at_b,
                        double beyond, double preference) {
  const Vec3& ha = a.half_extents;
  const Vec3& hb = b.half_extents;
  const Vec3 apart = at_a.position - at_b.position;
  const Mat3 c = at_a.rotation.transpose() * at_b.rotation;
  const Mat3 c_abs = c.cwiseAbs();
  const Vec3 in_a = at_a.rotation.transpose() * apart, in_b = at_b.rotation.transpose() * apart;
  BoxAxis best;
  const auto offer = [&](double separation) { return separation > best.separation + preference; };

  for (int j = 0; j < 3; ++j) {
    const double separation = std::abs(in_b[j]) - hb[j] - ha.dot(c_abs.col(j));
    if (!offer(separation)) continue;
    const bool positive = in_b[j] >= 0.0;
    best.kind = BoxAxis::FACE_B;
    best.separation = separation;
    best.face = 2 * j + (positive ? 1 : 0);
    best.normal = positive ? Vec3(at_b.rotation.col(j)) : Vec3(-at_b.rotation.col(j));
  }
  if (best.separation > beyond) return best;
  for (int i = 0; i < 3; ++i) {
    const double separation = std::abs(in_a[i]) - ha[i] - c_abs.row(i).dot(hb);
    if (!offer(separation)) continue;
    const bool positive = in_a[i] >= 0.0;  // A lies that way: its opposite face looks at B
    best.kind = BoxAxis::FACE_A;
    best.separation = separation;
    best.face = 2 * i + (positive ? 0 : 1);
    best.normal = positive ? Vec3(at_a.rotation.col(i)) : Vec3(-at_a.rotation.col(i));
  }
  if (best.separation > beyond) return best;
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double sine_sq = c(i1, j) * c(i1, j) + c(i2, j) * c(i2, j);
      if (sine_sq <= tolerance::parallel_edges * tolerance::parallel_edges) continue;
      const double along = in_a[i2] * c(i1, j) - in_a[i1] * c(i2, j);
      const double reach = ha[i1] * c_abs(i2, j) + ha[i2] * c_abs(i1, j) + hb[j1] * c_abs(i, j2) +
                           hb[j2] * c_abs(i, j1);
      const double separation = (std::abs(along) - reach) / std::sqrt(sine_sq);
      if (!offer(separation)) continue;
      const Vec3 cross = at_a.rotation.col(i).cross(at_b.rotation.col(j)).normalized();
      best.kind = BoxAxis::EDGES;
      best.separation = separation;
      best.edge_a = i;
      best.edge_b = j;
      best.normal = along >= 0.0 ? cross : Vec3(-cross);
    }
  }
  return best;
}

void contacts_box_box(const Box& a, const Placement& at_a, const Box& b, const Placement& at_b,
                      double margin, Manifold& out) {
  const double reach = a.half_extents.norm() + b.half_extents.norm() + margin;
  if ((at_a.position - at_b.position).squaredNorm() > reach * reach) return;
  const double small = std::min(size_of(a), size_of(b)), large = std::max(size_of(a), size_of(b));
  const BoxAxis axis =
      separating_axis(a, at_a, b, at_b, margin, tolerance::axis_preference * small + 1e-15 * large);
  if (axis.separation > margin) return;
  const double tolerance = tolerance::coincident * small + 1e-14 * large;

  const int first = out.size();
  if (axis.kind == BoxAxis::EDGES) {
    if (edge_edge_contact(a, at_a, b, at_b, axis, tolerance, out)) {
      flat_contacts(a, at_a, b, at_b, axis.normal, margin, tolerance, out);
      return;
    }
  } else {
    face_contacts(a, at_a, b, at_b, axis, margin, tolerance, out);
    if (out.least_separation(first) <= axis.separation + tolerance) return;
  }
  // The axis does not connect nearest points: the boxes are apart and nearest corner to corner or
  // corner to edge. Very close to contact that direction is rounding noise and the axis stands.
  if (axis.separation > tolerance::closest_direction * small) {
    const GjkResult nearest = gjk(BoxSupport{a, at_a}, BoxSupport{b, at_b}, axis.normal,
                                  std::numeric_limits<double>::infinity(), 1e-14 * large);
    if (nearest.distance > axis.separation + tolerance) {
      out.truncate(first);
      nearest_contact(margin, nearest, out);
      return;
    }
  }
  if (out.size() == first) deepest_contact(a, at_a, b, at_b, axis, out);
}

}  // namespace rb
