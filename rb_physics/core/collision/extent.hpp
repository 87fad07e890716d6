// How far a placed convex shape reaches along a direction.
#pragma once

#include "shape/shape.hpp"

namespace rb {

// max of direction . x over the shape, m for a unit direction. A half-space reaches `offset` along
// its own normal and infinitely far in every other direction. Throws std::invalid_argument for
// shapes that are not convex.
double extent(const Shape& shape, const Pose& pose, const Vec3& direction);

}  // namespace rb
