#include "collision/polytope.hpp"

#include <algorithm>
#include <cmath>

#include "collision/box_features.hpp"
#include "math/tolerances.hpp"

namespace rb {

namespace {

// The cube with half extents 1, its features numbered as a box's are.
HullData make_cube() {
  const Box box{Vec3::Ones()};
  HullData cube;
  for (int i = 0; i < 8; ++i) cube.vertices.push_back(box_corner(box, i));
  std::vector<std::vector<int>> loops;
  for (int face = 0; face < 6; ++face) {
    std::array<PolygonCorner, 4> corners;
    box_face(box, Placement{}, face, corners);
    std::vector<int> loop;
    for (const PolygonCorner& c : corners) {
      loop.push_back(static_cast<int>(feature_index(c.vertex)));
    }
    loops.push_back(loop);
  }
  finish_hull(loops, cube);
  // finish_hull numbers edges by their ends; a box numbers them by axis and signs.
  std::vector<HullEdge> edges(12);
  std::vector<int> number(12);
  for (int e = 0; e < 12; ++e) {
    const HullEdge& edge = cube.edges[e];
    const int changed = edge.tail ^ edge.head;
    number[e] = box_edge_index(changed == 1 ? 0 : changed == 2 ? 1 : 2, edge.tail);
    edges[number[e]] = edge;
  }
  cube.edges = edges;
  for (int& e : cube.face_edges) e = number[e];
  for (int& e : cube.edges_at) e = number[e];
  return cube;
}

const HullData& cube() {
  static const HullData data = make_cube();
  return data;
}

}  // namespace

void Polytope::place(const Box& box, const Placement& at) {
  topology_ = &cube();
  is_box_ = true;
  half_extents_ = box.half_extents;
  for (int i = 0; i < 8; ++i) corners_[i] = box_corner(box, i);
  local_vertices_ = corners_.data();
  vertex_count_ = 8;
  at_ = at;
  center_ = at.position;
  size_ = box.half_extents.maxCoeff();
  hint_ = 0;
}

void Polytope::place(const ConvexHull& hull, const Placement& at) {
  topology_ = hull.data.get();
  is_box_ = false;
  local_vertices_ = topology_->vertices.data();
  vertex_count_ = static_cast<int>(topology_->vertices.size());
  at_ = at;
  center_ = at.apply(topology_->center);
  size_ = topology_->size;
  hint_ = 0;
}

double Polytope::height(int face, const Vec3& p) const {
  const HullFace& f = topology_->faces[face];
  const double offset = is_box_ ? half_extents_[face / 2] : f.offset;
  return f.normal.dot(at_.apply_inverse(p)) - offset;
}

int Polytope::farthest(const Vec3& direction, int start) const {
  const Vec3 d = at_.rotation.transpose() * direction;
  if (is_box_) return (d.x() > 0.0 ? 1 : 0) | (d.y() > 0.0 ? 2 : 0) | (d.z() > 0.0 ? 4 : 0);
  constexpr int few = 16;  // up to so many, all are tried
  if (vertex_count_ <= few) {
    int best = 0;
    double most = d.dot(local_vertices_[0]);
    for (int i = 1; i < vertex_count_; ++i) {
      const double reach = d.dot(local_vertices_[i]);
      if (reach > most) {
        most = reach;
        best = i;
      }
    }
    return best;
  }
  // A linear function has no other local maximum on a convex polyhedron.
  int best = start;
  double most = d.dot(local_vertices_[best]);
  for (;;) {
    const int from = best;
    for (int i = topology_->neighbor_first[from]; i < topology_->neighbor_first[from + 1]; ++i) {
      // No branches: which neighbor is higher nobody can predict.
      const int v = topology_->neighbors[i];
      const double reach = d.dot(local_vertices_[v]);
      const bool higher = reach > most;
      most = higher ? reach : most;
      best = higher ? v : best;
    }
    if (best == from) return best;
  }
}

int Polytope::opposing_face(const Vec3& direction, int vertex) const {
  const int first = topology_->face_first[vertex], last = topology_->face_first[vertex + 1];
  int best = topology_->faces_at[first];
  double least = direction.dot(normal(best));
  for (int i = first + 1; i < last; ++i) {
    const int face = topology_->faces_at[i];
    const double d = direction.dot(normal(face));
    if (d < least - tolerance::coincident) {
      least = d;
      best = face;
    }
  }
  return best;
}

FacePolygon Polytope::polygon(int face, std::vector<PolygonCorner>& corners) const {
  const HullFace& f = topology_->faces[face];
  corners.resize(f.count);
  for (int i = 0; i < f.count; ++i) {
    const int v = topology_->face_vertices[f.first + i];
    corners[i].point = vertex(v);
    corners[i].vertex = make_feature(FeatureType::VERTEX, v);
    corners[i].edge = edge_feature(topology_->face_edges[f.first + i]);
  }
  FacePolygon polygon;
  polygon.normal = normal(face);
  polygon.face = make_feature(FeatureType::FACE, face);
  polygon.size = f.count;
  polygon.corners = corners.data();
  return polygon;
}

std::uint32_t Polytope::edge_feature(int edge) const {
  return make_feature(FeatureType::EDGE, edge);
}

std::uint32_t Polytope::feature_of(const int* vertices, int count) const {
  // Distinct vertices, ascending.
  int distinct[4] = {}, n = 0;
  for (int i = 0; i < count && i < 4; ++i) {
    int at = 0;
    while (at < n && distinct[at] < vertices[i]) ++at;
    if (at < n && distinct[at] == vertices[i]) continue;
    for (int k = n++; k > at; --k) distinct[k] = distinct[k - 1];
    distinct[at] = vertices[i];
  }
  if (n == 1) return make_feature(FeatureType::VERTEX, distinct[0]);
  if (n == 2) {
    int found = -1;
    for_each_edge_at(distinct[0], [&](int e) {
      if (topology_->edges[e].head == distinct[1]) found = e;
    });
    if (found >= 0) return edge_feature(found);
  }
  // A face that holds them all: the one through the first that reaches the others best.
  int best = 0, most = -1;
  for_each_face_at(distinct[0], [&](int f) {
    const HullFace& face = topology_->faces[f];
    const auto first = topology_->face_vertices.begin() + face.first;
    int held = 0;
    for (int i = 0; i < n; ++i) {
      held += std::find(first, first + face.count, distinct[i]) != first + face.count ? 1 : 0;
    }
    if (held > most) {
      most = held;
      best = f;
    }
  });
  return make_feature(FeatureType::FACE, best);
}

}  // namespace rb
