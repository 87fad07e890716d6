#include "collision/triangle_prism.hpp"

#include <algorithm>

namespace rb {

// Vertices 0 1 2 are the triangle's, 3 4 5 behind them. Faces: front, back, side of edge 0, 1, 2.
TrianglePrism::TrianglePrism() : hull_(std::make_shared<HullData>()) {
  hull_->vertices = {Vec3(0, 0, 0),  Vec3(1, 0, 0),  Vec3(0, 1, 0),
                     Vec3(0, 0, -1), Vec3(1, 0, -1), Vec3(0, 1, -1)};
  finish_hull({{0, 1, 2}, {5, 4, 3}, {1, 0, 3, 4}, {2, 1, 4, 5}, {0, 2, 5, 3}}, *hull_);
  shape_ = ConvexHull{hull_};
  for (std::size_t e = 0; e < hull_->edges.size(); ++e) {
    const HullEdge& edge = hull_->edges[e];
    edge_of_[e] = edge.head >= 3 ? -1 : edge.head - edge.tail == 2 ? 2 : edge.tail;
  }
}

const Shape& TrianglePrism::place(const SurfaceTriangle& t, double thickness) {
  HullData& hull = *hull_;
  const Vec3 back = -thickness * t.normal;
  for (int k = 0; k < 3; ++k) {
    hull.vertices[k] = t.corner[k];
    hull.vertices[k + 3] = t.corner[k] + back;
  }
  const auto set = [&](int face, const Vec3& normal, const Vec3& point) {
    hull.faces[face].normal = normal;
    hull.faces[face].offset = normal.dot(point);
  };
  set(0, t.normal, t.corner[0]);
  set(1, -t.normal, hull.vertices[3]);
  for (int k = 0; k < 3; ++k) {
    set(2 + k, (t.corner[(k + 1) % 3] - t.corner[k]).cross(t.normal).normalized(), t.corner[k]);
  }
  Vec3 lower = hull.vertices[0], upper = lower;
  hull.center.setZero();
  hull.radius = 0.0;
  for (const Vec3& v : hull.vertices) {
    lower = lower.cwiseMin(v);
    upper = upper.cwiseMax(v);
    hull.center += v / 6.0;
    hull.radius = std::max(hull.radius, v.norm());
  }
  hull.size = 0.5 * (upper - lower).maxCoeff();
  return shape_;
}

PrismFeature TrianglePrism::feature(std::uint32_t id) const {
  const int index = static_cast<int>(feature_index(id));
  switch (feature_type(id)) {
    case FeatureType::VERTEX:
      if (index < 3) return {PrismFeature::CORNER, index};
      break;
    case FeatureType::EDGE:
      if (index < 9 && edge_of_[index] >= 0) return {PrismFeature::EDGE, edge_of_[index]};
      break;
    case FeatureType::FACE:
      if (index == 0) return {PrismFeature::FACE, 0};
      break;
    case FeatureType::SMOOTH:
      break;
  }
  return {PrismFeature::NONE, 0};
}

}  // namespace rb
