// The separating axis of two boxes.
#pragma once

#include <limits>

#include "collision/manifold.hpp"
#include "shape/shape.hpp"

namespace rb {

struct BoxAxis {
  enum Kind { FACE_A, FACE_B, EDGES };
  Kind kind = FACE_B;
  double separation = -std::numeric_limits<double>::infinity();  // m, along the axis
  Vec3 normal;                                                   // unit, from B to A
  int face = 0;                // of the owner, 2 * axis + positive
  int edge_a = 0, edge_b = 0;  // axes of the edges
};

// The axis of greatest separation (least penetration): faces of B, faces of A, then edges, where a
// later one must win by `preference` (m). Stops early at one greater than `beyond`.
BoxAxis separating_axis(const Box& a, const Placement& at_a, const Box& b, const Placement& at_b,
                        double beyond, double preference);

}  // namespace rb
