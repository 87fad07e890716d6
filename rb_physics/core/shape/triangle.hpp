// One triangle of a mesh or height field with what contact needs to know of its surroundings.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "math/types.hpp"

namespace rb {

// How the surface goes on beyond an edge. Only convex and boundary edges can be touched: on a flat
// or concave one a face is always nearer, and a contact there would be a bump in a smooth surface.
enum class EdgeType : std::uint8_t { FLAT, CONCAVE, CONVEX, BOUNDARY };

struct SurfaceTriangle {
  std::array<Vec3, 3> corner;           // m, counterclockwise seen from outside
  Vec3 normal;                          // unit, outward
  std::array<EdgeType, 3> edge;         // edge k runs from corner k to corner k + 1
  std::array<Vec3, 3> neighbor_normal;  // beyond edge k; unused at a boundary
  std::int32_t face_id = 0;             // index of the triangle
  std::int32_t patch_id = 0;  // the flat patch it belongs to: one face, whatever its seams
  std::array<std::int32_t, 3> edge_id{};
  std::array<std::int32_t, 3> corner_id{};
};

// Dihedral angles (rad) below this count as flat: rounding of the vertices must not make bumps.
inline constexpr double flat_angle = 1e-6;

// Type of an edge through p between faces of unit normals n and m, where `beyond` is the third
// corner of the face with m.
inline EdgeType edge_type(const Vec3& n, const Vec3& m, const Vec3& p, const Vec3& beyond) {
  if (n.cross(m).squaredNorm() < flat_angle * flat_angle) {
    return n.dot(m) > 0.0 ? EdgeType::FLAT : EdgeType::CONVEX;  // folded back: a knife's edge
  }
  return n.dot(beyond - p) < 0.0 ? EdgeType::CONVEX : EdgeType::CONCAVE;
}

// The triangle as it is from behind: what was a ridge is a valley.
inline SurfaceTriangle turned_over(const SurfaceTriangle& t) {
  SurfaceTriangle back = t;
  back.normal = -t.normal;
  std::swap(back.corner[1], back.corner[2]);
  std::swap(back.corner_id[1], back.corner_id[2]);
  for (int k = 0; k < 3; ++k) {
    const int from = 2 - k;  // edges 0 1 2 become 2 1 0
    const bool ridge = t.edge[from] == EdgeType::CONVEX, valley = t.edge[from] == EdgeType::CONCAVE;
    back.edge[k] = ridge ? EdgeType::CONCAVE : valley ? EdgeType::CONVEX : t.edge[from];
    back.edge_id[k] = t.edge_id[from];
    back.neighbor_normal[k] = -t.neighbor_normal[from];
  }
  return back;
}

// Joins triangles across flat edges: neighbor(t, k) is the triangle beyond edge k or -1, is_flat(t,
// k) the edge's kind. Returns each triangle's patch, named after its first triangle.
template <class Neighbor, class IsFlat>
std::vector<std::int32_t> flat_patches(std::int32_t count, Neighbor&& neighbor, IsFlat&& is_flat) {
  std::vector<std::int32_t> patch(count, -1), open;
  for (std::int32_t first = 0; first < count; ++first) {
    if (patch[first] >= 0) continue;
    patch[first] = first;
    open.push_back(first);
    while (!open.empty()) {
      const std::int32_t t = open.back();
      open.pop_back();
      for (int k = 0; k < 3; ++k) {
        const std::int32_t other = neighbor(t, k);
        if (other < 0 || patch[other] >= 0 || !is_flat(t, k)) continue;
        patch[other] = first;
        open.push_back(other);
      }
    }
  }
  return patch;
}

}  // namespace rb
