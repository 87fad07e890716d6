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
  return cube;
}

const HullData& cube() {
  static const HullData data = make_cube();
  return data;
}

}  // namespace

void Polytope::place(const Box& box, const Placement& at) {
  topology_ = &cube();
  vertices_.resize(8);
  normals_.resize(6);
  offsets_.resize(6);
  for (int i = 0; i < 8; ++i) vertices_[i] = at.apply(box_corner(box, i));
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 n = at.rotation.col(axis);
    const double middle = n.dot(at.position);
    normals_[2 * axis] = -n;
    normals_[2 * axis + 1] = n;
    offsets_[2 * axis] = box.half_extents[axis] - middle;
    offsets_[2 * axis + 1] = box.half_extents[axis] + middle;
  }
  center_ = at.position;
  size_ = box.half_extents.maxCoeff();
}

void Polytope::place(const ConvexHull& hull, const Placement& at) {
  topology_ = hull.data.get();
  const std::size_t vertices = topology_->vertices.size(), faces = topology_->faces.size();
  vertices_.resize(vertices);
  normals_.resize(faces);
  offsets_.resize(faces);
  for (std::size_t i = 0; i < vertices; ++i) vertices_[i] = at.apply(topology_->vertices[i]);
  for (std::size_t i = 0; i < faces; ++i) {
    const HullFace& face = topology_->faces[i];
    normals_[i] = at.rotation * face.normal;
    offsets_[i] = face.offset + normals_[i].dot(at.position);
  }
  center_ = at.apply(topology_->center);
  size_ = topology_->size;
}

int Polytope::farthest(const Vec3& direction) const {
  int best = 0;
  double most = direction.dot(vertices_[0]);
  const int n = vertex_count();
  for (int i = 1; i < n; ++i) {
    const double d = direction.dot(vertices_[i]);
    if (d > most) {
      most = d;
      best = i;
    }
  }
  return best;
}

int Polytope::opposing_face(const Vec3& direction, int vertex) const {
  const int first = topology_->face_first[vertex], last = topology_->face_first[vertex + 1];
  int best = topology_->faces_at[first];
  double least = direction.dot(normals_[best]);
  for (int i = first + 1; i < last; ++i) {
    const int face = topology_->faces_at[i];
    const double d = direction.dot(normals_[face]);
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
    corners[i].point = vertices_[v];
    corners[i].vertex = make_feature(FeatureType::VERTEX, v);
    corners[i].edge = edge_feature(topology_->face_edges[f.first + i]);
  }
  FacePolygon polygon;
  polygon.normal = normals_[face];
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
  int distinct[4], n = 0;
  for (int i = 0; i < count && i < 4; ++i) {
    int at = 0;
    while (at < n && distinct[at] < vertices[i]) ++at;
    if (at < n && distinct[at] == vertices[i]) continue;
    for (int k = n++; k > at; --k) distinct[k] = distinct[k - 1];
    distinct[at] = vertices[i];
  }
  if (n == 1) return make_feature(FeatureType::VERTEX, distinct[0]);
  if (n == 2) {
    for (std::size_t e = 0; e < topology_->edges.size(); ++e) {
      const HullEdge& edge = topology_->edges[e];
      if (edge.tail == distinct[0] && edge.head == distinct[1]) {
        return edge_feature(static_cast<int>(e));
      }
    }
  }
  // A face that holds them all: the one through the first that reaches the others best.
  int best = 0, most = -1;
  for (std::size_t f = 0; f < topology_->faces.size(); ++f) {
    const HullFace& face = topology_->faces[f];
    const auto first = topology_->face_vertices.begin() + face.first;
    int held = 0;
    for (int i = 0; i < n; ++i) {
      held += std::find(first, first + face.count, distinct[i]) != first + face.count ? 1 : 0;
    }
    if (held > most) {
      most = held;
      best = static_cast<int>(f);
    }
  }
  return make_feature(FeatureType::FACE, best);
}

}  // namespace rb
