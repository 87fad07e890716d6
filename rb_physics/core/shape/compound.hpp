// Building a compound from placed parts.
#pragma once

#include <vector>

#include "shape/shape.hpp"

namespace rb {

// Flattens nested compounds into leaves. Throws std::invalid_argument for an empty list, for more
// than 4096 leaves, and for parts that are not solid (half-space, triangle mesh, height field).
Compound make_compound(const std::vector<CompoundPart>& parts);

}  // namespace rb
