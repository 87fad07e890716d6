// One point of a contact manifold (S7, S8): where two shapes meet, along which normal, how deep,
// and which features met. Bodies A and B; the normal N points from B to A (the notes' convention).
#pragma once

#include <cstdint>
#include <vector>

#include "math/types.hpp"

namespace rb {

// The features that met (S8). The order of A and B does not matter: VERTEX_FACE is also
// face-vertex. SMOOTH: a curved surface touches. Values are part of the public interface
// (rb.ContactKind).
enum class ContactKind : std::uint8_t {
  VERTEX_FACE = 0,
  EDGE_EDGE = 1,
  EDGE_FACE = 2,
  FACE_FACE = 3,
  SMOOTH = 4,
};

// Which body's surface carries the normal as it moves (needed for N-dot and N-double-dot, S10).
enum class NormalOwner : std::uint8_t {
  A = 0,        // a face of A: N turns with A
  B = 1,        // a face of B: N turns with B
  EDGES = 2,    // N = e_A x e_B: turns with both edges
  CENTERS = 3,  // N along the line between the two surfaces' centres of curvature
};

struct ContactPoint {
  Vec3 point_a;              // m, world, on the surface of A
  Vec3 point_b;              // m, world, on the surface of B
  Vec3 normal;               // unit, world, from B to A
  double separation = 0.0;   // m, = N . (point_a - point_b), negative when overlapping
  std::int64_t feature = 0;  // stable id of the pair of features, >= 0; survives from step to step
  ContactKind kind = ContactKind::SMOOTH;
  NormalOwner normal_owner = NormalOwner::CENTERS;
};

using ContactPoints = std::vector<ContactPoint>;

}  // namespace rb
