#include <cmath>
#include <limits>
#include <vector>

#include "collision/pairs.hpp"
#include "collision/reduce.hpp"
#include "math/tolerances.hpp"
#include "shape/hull.hpp"

namespace rb {

namespace {

// Which vertices lie on the lowest feature: those of a face or edge parallel to the plane, or one.
struct Lowest {
  ContactKind kind = ContactKind::VERTEX_FACE;
  double height = 0.0;  // members lie at most this high, m
};

Lowest lowest_feature(const HullData& hull, const Vec3& slope, int vertex) {
  const double height = slope.dot(hull.vertices[vertex]);
  Lowest lowest{ContactKind::VERTEX_FACE, height};
  for (int i = hull.face_first[vertex]; i < hull.face_first[vertex + 1]; ++i) {
    const HullFace& face = hull.faces[hull.faces_at[i]];
    const double cosine = slope.dot(face.normal);
    if (cosine < 0.0 &&
        (face.normal - cosine * slope).squaredNorm() <= tolerance::parallel * tolerance::parallel) {
      lowest.kind = ContactKind::FACE_FACE;
      for (int k = 0; k < face.count; ++k) {
        const Vec3& v = hull.vertices[hull.face_vertices[face.first + k]];
        lowest.height = std::max(lowest.height, slope.dot(v));
      }
      return lowest;
    }
  }
  for (int i = hull.neighbor_first[vertex]; i < hull.neighbor_first[vertex + 1]; ++i) {
    const Vec3 edge = hull.vertices[hull.neighbors[i]] - hull.vertices[vertex];
    const double rise = slope.dot(edge);
    if (rise <= tolerance::parallel * edge.norm()) {
      lowest.kind = ContactKind::EDGE_FACE;
      lowest.height = std::max(lowest.height, height + rise);
    }
  }
  return lowest;
}

bool faces_plane(const HullData& hull, const Vec3& slope, int vertex) {
  for (int i = hull.face_first[vertex]; i < hull.face_first[vertex + 1]; ++i) {
    if (slope.dot(hull.faces[hull.faces_at[i]].normal) < -tolerance::parallel) return true;
  }
  return false;
}

}  // namespace

void contacts_hull_half_space(const ConvexHull& a, const Placement& at_a, const HalfSpace& b,
                              const Placement& at_b, double margin, Manifold& out) {
  static thread_local std::vector<ManifoldPoint> points;
  const HullData& hull = *a.data;
  const Vec3 normal = at_b.rotation * b.normal;
  const Vec3 slope = at_a.rotation.transpose() * normal;
  const double origin_height = normal.dot(at_a.position - at_b.position) - b.offset;
  int deepest = 0;
  double least = std::numeric_limits<double>::infinity();
  const int count = static_cast<int>(hull.vertices.size());
  for (int i = 0; i < count; ++i) {
    const double height = slope.dot(hull.vertices[i]);
    if (height < least) {
      least = height;
      deepest = i;
    }
  }
  if (!(origin_height + least <= margin)) return;
  const Lowest lowest = lowest_feature(hull, slope, deepest);
  points.clear();
  for (int i = 0; i < count; ++i) {
    const double height = slope.dot(hull.vertices[i]);
    const double separation = origin_height + height;
    if (!(separation <= margin) || !(i == deepest || faces_plane(hull, slope, i))) continue;
    ManifoldPoint p;
    p.normal = normal;
    p.point_a = at_a.apply(hull.vertices[i]);
    p.point_b = p.point_a - separation * normal;
    p.separation = separation;
    p.feature_a = make_feature(FeatureType::VERTEX, i);
    p.feature_b = make_feature(FeatureType::FACE, 0);
    p.kind = height <= lowest.height ? lowest.kind : ContactKind::VERTEX_FACE;
    p.normal_owner = NormalOwner::B;
    points.push_back(p);
  }
  reduce_cloud(points, normal, out);
}

}  // namespace rb
