// Contact points of a reference face and an incident face by clipping (Ericson 2005, section 8.3.4:
// Sutherland-Hodgman), each point named by the features that make it.
#pragma once

#include "collision/face_polygon.hpp"
#include "collision/manifold.hpp"

namespace rb {

// The part of `incident` over `reference` that lies within `margin` above its plane, added to `out`
// with at most eight points. `reference_is_b` says whose face carries the normal. Lengths below
// `tolerance` (m) count as zero when features are named.
void clip_faces(const FacePolygon& reference, const FacePolygon& incident, bool reference_is_b,
                double margin, double tolerance, Manifold& out);

// Faces within 10 degrees of a contact normal lie nearly flat on each other.
constexpr double flat_cosine = 0.985;

// To the crossing of two edges, last in `out`: the corners of the facing faces, where those lie
// nearly flat on each other, because a little turn brings them down. Not beside the crossing itself
// (0.02 of `size`, m, of the smaller shape), which they would say twice, and none deeper than it:
// its depth is the least there is.
void add_beside_crossing(const Manifold& corners, const Vec3& normal, double size, Manifold& out);

}  // namespace rb
