// A simplex of up to four points of the Minkowski difference A - B and the point of it nearest the
// origin (van den Bergen 2003, chapter 4; Ericson 2005, section 5.1).
#pragma once

#include <array>

#include "math/types.hpp"

namespace rb {

struct SimplexVertex {
  Vec3 w;           // m, = a - b
  Vec3 a;           // m, support point of A
  Vec3 b;           // m, support point of B
  int index_a = 0;  // vertex of A, where A has vertices
  int index_b = 0;
};

struct Simplex {
  std::array<SimplexVertex, 4> vertex;
  std::array<double, 4> weight{};  // barycentric, of the nearest point
  int size = 0;

  bool contains(const Vec3& w) const {
    for (int i = 0; i < size; ++i) {
      if (vertex[i].w == w) return true;
    }
    return false;
  }
  // Its direction is right to rounding however near the origin a large simplex passes: that of a
  // triangle's normal, or across an edge.
  Vec3 nearest() const;
  Vec3 nearest_on_a() const {
    Vec3 sum = weight[0] * vertex[0].a;
    for (int i = 1; i < size; ++i) sum += weight[i] * vertex[i].a;
    return sum;
  }
  Vec3 nearest_on_b() const {
    Vec3 sum = weight[0] * vertex[0].b;
    for (int i = 1; i < size; ++i) sum += weight[i] * vertex[i].b;
    return sum;
  }

  enum class Step { INSIDE, STUCK, NEARER };

  // Drops the vertices that do not support the point nearest the origin and sets the weights:
  // NEARER. Nothing changes when the origin lies inside the tetrahedron (INSIDE). When the square
  // of the distance does not fall below `distance_sq`, the last vertex goes again (STUCK).
  Step reduce_to_nearest(double distance_sq);
};

}  // namespace rb
