// A face of a polytope as a polygon whose corners and edges know their names.
#pragma once

#include <cstdint>

#include "math/types.hpp"

namespace rb {

struct PolygonCorner {
  Vec3 point;            // m
  std::uint32_t vertex;  // feature of this corner
  std::uint32_t edge;    // feature of the edge to the next corner
};

// Corners counterclockwise seen from outside; storage belongs to the caller.
struct FacePolygon {
  Vec3 normal;         // unit, outward
  std::uint32_t face;  // feature
  int size = 0;
  const PolygonCorner* corners = nullptr;
};

}  // namespace rb
