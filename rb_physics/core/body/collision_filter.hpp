// Which bodies may touch.
#pragma once

#include <cstdint>

namespace rb {

// Two bodies may touch when each one's mask has a bit of the other's layer.
struct CollisionFilter {
  std::uint32_t layer = 1;
  std::uint32_t mask = 0xffffffffu;

  bool accepts(const CollisionFilter& other) const {
    return (layer & other.mask) != 0 && (other.layer & mask) != 0;
  }
};

}  // namespace rb
