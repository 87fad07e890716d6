// Bounding volume hierarchy over boxes that never change: nodes in preorder, each knowing where its
// subtree ends, so that a walk needs no stack.
#pragma once

#include <cstdint>
#include <vector>

#include "math/types.hpp"

namespace rb {

class Bvh {
 public:
  Bvh() = default;
  explicit Bvh(const std::vector<Aabb>& boxes);  // halves at the median along the longest axis

  // Calls visit(index) for every box that `accept` takes; accept(box) must be true for a box that
  // holds an accepted one. It is asked again at every node: it may shrink while the walk goes on.
  template <class Accept, class Visit>
  void walk(Accept&& accept, Visit&& visit) const {
    const std::int32_t size = static_cast<std::int32_t>(nodes_.size());
    for (std::int32_t i = 0; i < size;) {
      const Node& node = nodes_[i];
      if (!accept(node.box)) {
        i = node.end;
        continue;
      }
      if (node.item >= 0) visit(node.item);
      ++i;
    }
  }

  Aabb bounds() const { return nodes_.front().box; }  // not for an empty hierarchy

 private:
  struct Node {
    Aabb box;
    std::int32_t end;   // first node behind this subtree
    std::int32_t item;  // index of the box, -1 for an inner node
  };

  void build(const std::vector<Aabb>& boxes, std::vector<std::int32_t>& order, std::int32_t first,
             std::int32_t last);

  std::vector<Node> nodes_;
};

// Does the ray origin + t direction, t in [0, t_max], meet the box? Errs on the side of yes by
// rounding.
bool ray_meets(const Aabb& box, const Vec3& origin, const Vec3& direction, double t_max);

}  // namespace rb
