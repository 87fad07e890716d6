// A placed convex polyhedron, box or hull, as the separating axis test and face clipping see it.
#pragma once

#include <vector>

#include "collision/face_polygon.hpp"
#include "collision/gjk.hpp"
#include "collision/manifold.hpp"
#include "shape/hull.hpp"
#include "shape/shape.hpp"

namespace rb {

class Polytope {
 public:
  void place(const Box& box, const Placement& at);
  void place(const ConvexHull& hull, const Placement& at);

  const HullData& topology() const { return *topology_; }
  int vertex_count() const { return static_cast<int>(vertices_.size()); }
  int face_count() const { return static_cast<int>(offsets_.size()); }
  const Vec3& vertex(int i) const { return vertices_[i]; }
  const Vec3& normal(int face) const { return normals_[face]; }
  double offset(int face) const { return offsets_[face]; }  // m, normal . x on the face
  const Vec3& center() const { return center_; }            // m, an inner point
  double size() const { return size_; }                     // m

  int farthest(const Vec3& direction) const;  // vertex; the lowest index wins a tie
  SupportPoint operator()(const Vec3& direction) const {
    const int i = farthest(direction);
    return {vertices_[i], i};
  }
  // Second derivative of the support function: corners are sharp.
  double curvature(const Vec3&, const Vec3&, const Vec3&) const { return 0.0; }
  // Of the faces around a vertex, the one that looks most against `direction`.
  int opposing_face(const Vec3& direction, int vertex) const;
  FacePolygon polygon(int face, std::vector<PolygonCorner>& corners) const;
  std::uint32_t edge_feature(int edge) const;
  // The feature spanned by the vertices of a simplex.
  std::uint32_t feature_of(const int* vertices, int count) const;

 private:
  const HullData* topology_ = nullptr;
  std::vector<Vec3> vertices_, normals_;
  std::vector<double> offsets_;
  Vec3 center_;
  double size_ = 0.0;
};

}  // namespace rb
