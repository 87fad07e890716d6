#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/ball_contact.hpp"
#include "collision/gjk.hpp"
#include "collision/polytope.hpp"
#include "math/tolerances.hpp"

namespace rb {

namespace {

// Point of a face's outline nearest to p, which lies in the plane of the face, and the edge it is
// on; no edge (-1) when p is over the face.
struct OnOutline {
  Vec3 point;
  int edge = -1;
};
OnOutline nearest_on_outline(const HullData& hull, const HullFace& face, const Vec3& p) {
  const double rounding = 1e-15 * hull.size;
  OnOutline best{p};
  double least_sq = std::numeric_limits<double>::infinity();
  for (int i = 0; i < face.count; ++i) {
    const Vec3& tail = hull.vertices[hull.face_vertices[face.first + i]];
    const Vec3& head = hull.vertices[hull.face_vertices[face.first + (i + 1) % face.count]];
    const Vec3 along = head - tail;
    if (along.cross(face.normal).dot(p - tail) <= rounding * along.norm()) continue;
    const double t = std::clamp(along.dot(p - tail) / along.squaredNorm(), 0.0, 1.0);
    const Vec3 point = tail + t * along;
    const double gap_sq = (p - point).squaredNorm();
    if (gap_sq < least_sq) {
      least_sq = gap_sq;
      best = {point, hull.face_edges[face.first + i]};
    }
  }
  return best;
}

}  // namespace

void contacts_ball_hull(const Ball& a, const Placement& at_a, const ConvexHull& b,
                        const Placement& at_b, double margin, Manifold& out) {
  static thread_local Polytope polytope;
  const HullData& hull = *b.data;
  const Vec3 center = at_b.apply_inverse(at_a.position);
  polytope.place(b, Placement{});
  const auto point = [&](const Vec3&) { return SupportPoint{center, 0}; };
  const double close = 1e-9 * hull.size;  // nearer, only the faces give a direction
  const GjkResult nearest =
      gjk(point, polytope, Vec3(center - hull.center), margin + a.radius, close);
  if (nearest.status == GjkStatus::BEYOND) return;
  const bool apart = nearest.status != GjkStatus::OVERLAP && nearest.distance > close;
  // The face plane the centre is highest above; the lowest index decides a tie.
  int face = 0;
  double height = -std::numeric_limits<double>::infinity();
  const auto offer = [&](int f) {
    const double h = hull.faces[f].normal.dot(center) - hull.faces[f].offset;
    if (h > height + tolerance::axis_preference * hull.size) {
      height = h;
      face = f;
    }
  };
  if (apart) {
    polytope.for_each_face_at(nearest.simplex.vertex[0].index_b, offer);
  } else {
    for (int f = 0; f < polytope.face_count(); ++f) offer(f);
  }
  Vec3 normal = hull.faces[face].normal;
  Vec3 on_hull = center - height * normal;
  std::uint32_t feature = make_feature(FeatureType::FACE, face);
  const double tolerance =
      tolerance::coincident * std::min(a.radius, hull.size) + 1e-12 * hull.size;
  if (apart && nearest.distance > height + tolerance) {
    height = nearest.distance;
    normal = nearest.toward_a / height;
    on_hull = nearest.simplex.nearest_on_b();
    int vertices[4];
    for (int i = 0; i < nearest.simplex.size; ++i) {
      vertices[i] = nearest.simplex.vertex[i].index_b;
    }
    feature = polytope.feature_of(vertices, nearest.simplex.size);
  } else if (const OnOutline outline = nearest_on_outline(hull, hull.faces[face], on_hull);
             outline.edge >= 0) {
    // A hair beside the face, no farther from its edge than from its plane by more than rounding.
    on_hull = outline.point;
    if (apart) {
      feature = polytope.edge_feature(outline.edge);
      height = (center - on_hull).norm();
      normal = (center - on_hull) / height;
    }
  }
  add_ball_contact(a, at_a, at_b, normal, on_hull, height, feature, margin, out);
}

}  // namespace rb
