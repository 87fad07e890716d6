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

}  // namespace rb
