// A fixed order of the two shapes of a pair, so that a query and the same query with A and B
// exchanged do the same arithmetic and give mirrored answers, bit for bit.
#pragma once

#include "shape/shape.hpp"

namespace rb {

// True when the pair is to be computed as (b, a). Simpler shapes come first, larger ones second;
// equal shapes are ordered by where they are.
bool comes_second(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b);

}  // namespace rb
