// A triangle mesh as a static surface: triangles counterclockwise seen from outside, one-sided,
// with adjacency and a bounding volume hierarchy. Built once, shared.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "math/mass_properties.hpp"
#include "math/types.hpp"
#include "shape/bvh.hpp"
#include "shape/shape.hpp"
#include "shape/triangle.hpp"

namespace rb {

struct MeshData {
  std::vector<Vec3> vertices;  // m, body coordinates, duplicates merged
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<Vec3> normals;                           // unit, per triangle
  std::vector<std::array<std::int32_t, 3>> neighbors;  // per triangle and edge, -1 at a boundary
  std::vector<std::array<EdgeType, 3>> edges;          // per triangle and edge
  std::vector<std::int32_t> ring_first;                // size vertices + 1, index into ring
  std::vector<std::int32_t> ring;                      // vertices joined to a vertex, ascending
  std::vector<bool> at_boundary;                       // per vertex
  std::vector<std::int32_t> patches;                   // per triangle: the flat patch it belongs to
  Bvh bvh;
  bool closed = false;  // every edge has two triangles
  double volume = 0.0;  // m^3, signed; for a closed mesh
  MassProperties mass;  // density 1 kg/m^3; only for a closed mesh of positive volume
  double size = 0.0;    // m, half the diagonal of the bounding box

  SurfaceTriangle triangle(std::int32_t index) const;
  // Could a body touch this vertex with that normal: no edge leads up along it, and one leads down
  // or the surface ends here? On flat ground the faces do it.
  bool vertex_admits(std::int32_t vertex, const Vec3& normal) const;
  template <class Visit>
  void for_each_triangle(const Aabb& box, Visit&& visit) const {
    bvh.walk([&](const Aabb& b) { return b.overlaps(box); }, visit);
  }
};

// Vertices closer than 1e-12 of the size are merged. Throws std::invalid_argument, naming the
// triangle or vertex, for: no triangle; a vertex that isn't finite; an index out of range; a
// triangle without area; an edge shared by more than two triangles or by two that run it the same
// way (inconsistent winding); a closed mesh turned inside out (negative volume). Open meshes are
// fine: they are surfaces.
TriangleMesh make_triangle_mesh(const std::vector<Vec3>& vertices,
                                const std::vector<std::array<std::int32_t, 3>>& triangles);

}  // namespace rb
