// A convex polyhedron: vertices, merged faces, edges, and what follows from them. Built once,
// shared.
#pragma once

#include <memory>
#include <vector>

#include "math/mass_properties.hpp"
#include "math/types.hpp"
#include "shape/shape.hpp"

namespace rb {

struct HullFace {
  Vec3 normal;        // unit, outward
  double offset = 0;  // m, normal . x = offset on the face
  int first = 0;      // index into HullData::face_vertices and ::face_edges
  int count = 0;      // corners, >= 3
};

struct HullEdge {
  int tail = 0;  // vertex indices, tail < head
  int head = 0;
  int left = 0;   // face on which the edge runs tail -> head counterclockwise seen from outside
  int right = 0;  // the other face
};

struct HullData {
  std::vector<Vec3> vertices;      // m, body coordinates, all extreme points
  std::vector<HullFace> faces;     // coplanar triangles merged
  std::vector<int> face_vertices;  // corners of all faces, counterclockwise seen from outside
  std::vector<int> face_edges;     // edge from corner i to corner i + 1 of the same face
  std::vector<HullEdge> edges;
  std::vector<int> neighbor_first;  // size vertices + 1, index into neighbors
  std::vector<int> neighbors;       // vertices joined to a vertex by an edge, ascending
  std::vector<int> edges_at;        // the edges to those neighbors
  std::vector<int> face_first;      // size vertices + 1, index into faces_at
  std::vector<int> faces_at;        // faces around a vertex, ascending
  MassProperties mass;              // density 1 kg/m^3
  Vec3 center = Vec3::Zero();       // m, an inner point: the centre of mass
  double size = 0;                  // m, half the largest side of the bounding box
  double radius = 0;                // m, farthest vertex from the origin
};

// The convex hull of points (m, body coordinates; inner points are dropped, and those nearer to an
// earlier one than 1e-8 of the extent). Throws
// std::invalid_argument for points that span no volume, saying what is wrong with them.
ConvexHull make_hull(const std::vector<Vec3>& points);

// Derives everything else from the vertices and the corners of each face.
void finish_hull(const std::vector<std::vector<int>>& loops, HullData& hull);

}  // namespace rb
