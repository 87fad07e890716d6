// The triangles of a convex hull, with exact arithmetic deciding on which side a point lies.
#pragma once

#include <array>
#include <vector>

#include "math/types.hpp"

namespace rb {

struct HullTriangle {
  std::array<int, 3> vertex;    // indices into the points, counterclockwise seen from outside
  std::array<int, 3> neighbor;  // triangle across the edge vertex[i] -> vertex[i + 1]
};

// Quickhull (Barber, Dobkin, Huhdanpaa 1996) of points rounded to a grid of 2^-38 of their extent,
// on which every orientation test is exact: the result is a closed, convex triangulation of the
// grid points whatever the input. Throws std::invalid_argument when the points are fewer than four,
// not finite, or lie within 1e-6 of their extent of a point, a line or a plane.
std::vector<HullTriangle> hull_triangles(const std::vector<Vec3>& points);

}  // namespace rb
