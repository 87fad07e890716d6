// A convex polyhedron: vertices, merged faces, edges, and what follows from them. Built once,
// shared.
#pragma once

#include <memory>
#include <vector>

#include "math/mass_properties.hpp"
#include "math/types.hpp"

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
  MassProperties mass;              // density 1 kg/m^3
  Vec3 center = Vec3::Zero();       // m, an inner point: the centre of mass
  double size = 0;                  // m, half the diagonal of the bounding box
};

}  // namespace rb
