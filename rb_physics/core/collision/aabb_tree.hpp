// A binary tree of axis-aligned boxes that changes leaf by leaf. Insertion goes where the surface
// area grows least (Goldsmith & Salmon 1987), and rotations on the way up keep the tree good in any
// order of insertion (Kopta et al. 2012). Boxes must be finite.
//
// The shape of the tree depends on its history; the set of leaves a query visits doesn't, so
// callers sort what they collect.
#pragma once

#include <cstdint>
#include <vector>

#include "math/types.hpp"

namespace rb {

class AabbTree {
 public:
  // Adds a leaf with the caller's number and returns its node index, valid until removed.
  std::int32_t insert(const Aabb& box, std::int32_t user);
  void remove(std::int32_t leaf);

  const Aabb& box(std::int32_t node) const { return nodes_[node].box; }
  void set_user(std::int32_t leaf, std::int32_t user) { nodes_[leaf].user = user; }
  int size() const { return leaves_; }
  int height() const;          // longest path from the root, 0 for one leaf
  double surface_sum() const;  // m^2, over the inner nodes: the tree's cost

  // Calls visit(user) for every leaf whose box `accept(box)` takes; accept must be monotonic: a box
  // that holds an accepted box is accepted. No stack, no allocation: the walk climbs by parents.
  template <class Accept, class Visit>
  void walk(Accept&& accept, Visit&& visit) const;

 private:
  struct Node {
    Aabb box{Vec3::Zero(), Vec3::Zero()};
    std::int32_t parent = -1;          // next free node while unused
    std::int32_t child[2] = {-1, -1};  // -1 for a leaf
    std::int32_t user = -1;
    bool is_leaf() const { return child[0] < 0; }
  };

  std::int32_t allocate();
  void release(std::int32_t node);
  std::int32_t best_sibling(const Aabb& box) const;
  void refit_from(std::int32_t node);
  void rotate(std::int32_t node);

  std::vector<Node> nodes_;
  std::int32_t root_ = -1;
  std::int32_t free_ = -1;
  int leaves_ = 0;
};

template <class Accept, class Visit>
void AabbTree::walk(Accept&& accept, Visit&& visit) const {
  std::int32_t node = root_;
  while (node >= 0) {
    const Node& n = nodes_[node];
    if (accept(n.box)) {
      if (!n.is_leaf()) {
        node = n.child[0];
        continue;
      }
      visit(n.user);
    }
    // Next subtree to the right: climb while this is a right child.
    std::int32_t parent = nodes_[node].parent;
    while (parent >= 0 && nodes_[parent].child[1] == node) {
      node = parent;
      parent = nodes_[node].parent;
    }
    node = parent >= 0 ? nodes_[parent].child[1] : -1;
  }
}

}  // namespace rb
