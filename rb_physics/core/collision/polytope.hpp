// A placed convex polyhedron, box or hull, as the separating axis test and face clipping see it.
#pragma once

#include <array>
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
  int vertex_count() const { return vertex_count_; }
  int face_count() const { return static_cast<int>(topology_->faces.size()); }
  Vec3 vertex(int i) const { return at_.apply(local_vertices_[i]); }
  Vec3 normal(int face) const { return at_.rotation * topology_->faces[face].normal; }
  double height(int face, const Vec3& p) const;   // m, of p above the plane of a face
  const Vec3& center() const { return center_; }  // m, an inner point
  double size() const { return size_; }           // m

  // The farthest vertex; the search walks uphill from `start`.
  int farthest(const Vec3& direction, int start = 0) const;
  SupportPoint operator()(const Vec3& direction) const {
    hint_ = farthest(direction, hint_);
    return {vertex(hint_), hint_};
  }
  SupportPoint from(const Vec3& direction, int start) const {
    const int i = farthest(direction, start);
    return {vertex(i), i};
  }
  // Second derivative of the support function: corners are sharp.
  double curvature(const Vec3&, const Vec3&, const Vec3&) const { return 0.0; }
  // Of the faces around a vertex, the one that looks most against `direction`.
  int opposing_face(const Vec3& direction, int vertex) const;
  FacePolygon polygon(int face, std::vector<PolygonCorner>& corners) const;
  std::uint32_t edge_feature(int edge) const;
  // The feature spanned by the vertices of a simplex.
  std::uint32_t feature_of(const int* vertices, int count) const;

  // Calls visit(face) for the faces, visit(edge) for the edges around a vertex, ascending.
  template <class Visit>
  void for_each_face_at(int vertex, const Visit& visit) const {
    for (int i = topology_->face_first[vertex]; i < topology_->face_first[vertex + 1]; ++i) {
      visit(topology_->faces_at[i]);
    }
  }
  template <class Visit>
  void for_each_edge_at(int vertex, const Visit& visit) const {
    for (int i = topology_->neighbor_first[vertex]; i < topology_->neighbor_first[vertex + 1];
         ++i) {
      visit(topology_->edges_at[i]);
    }
  }

 private:
  const HullData* topology_ = nullptr;
  const Vec3* local_vertices_ = nullptr;
  int vertex_count_ = 0;
  bool is_box_ = false;
  std::array<Vec3, 8> corners_;
  Vec3 half_extents_;
  Placement at_;
  Vec3 center_;
  double size_ = 0.0;
  mutable int hint_ = 0;  // where the last support query of this placement ended
};

// The polytope of a box or hull, valid until the thread places another of its kind.
template <class Shape>
const Polytope& placed_polytope(const Shape& shape, const Placement& at) {
  static thread_local Polytope polytope;
  polytope.place(shape, at);
  return polytope;
}

}  // namespace rb
