// Contacts of two convex polyhedra: boxes, hulls, and (as flat polytopes) triangles.
#pragma once

#include "collision/manifold.hpp"
#include "collision/polytope.hpp"

namespace rb {

// The axis along which two polytopes are farthest apart, or overlap least.
struct PolytopeAxis {
  enum Kind { FACE_A, FACE_B, EDGES };
  Kind kind = FACE_B;
  double separation = 0.0;  // m
  Vec3 normal;              // unit, from B to A
  int feature_a = 0;        // face or edge of A
  int feature_b = 0;        // face or edge of B
};

// Separating axis test over faces of B, faces of A and pairs of edges that meet on the Gauss map
// (Gregorius, GDC 2013); a later axis must win by `preference` (m).
PolytopeAxis separating_axis(const Polytope& a, const Polytope& b, double preference);

// Adds the contact points with separation <= margin (m).
void contacts_polytopes(const Polytope& a, const Polytope& b, double margin, Manifold& out);

}  // namespace rb
