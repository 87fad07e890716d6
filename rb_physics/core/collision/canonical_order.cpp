#include "collision/canonical_order.hpp"

#include <cmath>

namespace rb {

namespace {

int rank(const Shape& shape) {
  // Indexed like the variant: particle, sphere, box, capsule, cylinder, half-space, hull, mesh,
  // height field, compound.
  static constexpr int ranks[] = {0, 1, 4, 2, 3, 9, 5, 7, 8, 6};
  static_assert(std::size(ranks) == std::variant_size_v<Shape>);
  return ranks[shape.index()];
}

// Sign of a - b for two shapes of one type, 0 when equal.
int compare(const Shape& a, const Shape& b) {
  const double size_a = characteristic_size(a), size_b = characteristic_size(b);
  if (size_a != size_b) return size_a < size_b ? -1 : 1;
  if (const auto* box_a = std::get_if<Box>(&a)) {
    const auto* box_b = std::get_if<Box>(&b);
    for (int i = 0; i < 3; ++i) {
      const double d = box_a->half_extents[i] - box_b->half_extents[i];
      if (d != 0.0) return d < 0.0 ? -1 : 1;
    }
  }
  return 0;
}

}  // namespace

bool comes_second(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  const int rank_a = rank(a), rank_b = rank(b);
  if (rank_a != rank_b) return rank_a > rank_b;
  const int size = compare(a, b);
  if (size != 0) return size > 0;
  // By the coordinate in which they differ most: of two boxes of a stack the lower one is B,
  // whatever rounding does to the other coordinates.
  const Vec3 apart = pose_a.position - pose_b.position;
  int axis = 2;
  for (const int i : {1, 0}) {
    if (std::abs(apart[i]) > std::abs(apart[axis])) axis = i;
  }
  if (apart[axis] != 0.0) return apart[axis] < 0.0;
  for (int i = 0; i < 4; ++i) {
    const double d = pose_a.orientation.coeffs()[i] - pose_b.orientation.coeffs()[i];
    if (d != 0.0) return d < 0.0;
  }
  return false;
}

}  // namespace rb
