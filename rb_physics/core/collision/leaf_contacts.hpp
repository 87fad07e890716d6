// The narrow phase's table: which function finds the contacts of which two convex shapes.
#pragma once

#include "collision/manifold.hpp"
#include "shape/shape.hpp"

namespace rb {

// `out` gets the contacts of two convex shapes (no mesh, height field or compound), in the frame of
// the placements. The first shape must not come after the second in the canonical order of types.
void leaf_contacts(const Shape& a, const Placement& at_a, const Shape& b, const Placement& at_b,
                   double margin, Manifold& out);

}  // namespace rb
