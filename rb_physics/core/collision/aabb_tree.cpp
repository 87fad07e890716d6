#include "collision/aabb_tree.hpp"

#include <algorithm>

namespace rb {
namespace {

// Half the surface: only ratios matter.
double area(const Aabb& b) {
  const Vec3 d = b.upper - b.lower;
  return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
}

Aabb united(const Aabb& a, const Aabb& b) {
  return {a.lower.cwiseMin(b.lower), a.upper.cwiseMax(b.upper)};
}

}  // namespace

std::int32_t AabbTree::allocate() {
  if (free_ < 0) {
    nodes_.emplace_back();
    return static_cast<std::int32_t>(nodes_.size()) - 1;
  }
  const std::int32_t node = free_;
  free_ = nodes_[node].parent;
  nodes_[node].parent = -1;
  return node;
}

void AabbTree::release(std::int32_t node) {
  nodes_[node] = Node{};
  nodes_[node].parent = free_;
  free_ = node;
}

// Greedy descent: pairing with `node` costs the area of the new inner node plus what every ancestor
// grows by. Going down pays only while some child could still be cheaper.
std::int32_t AabbTree::best_sibling(const Aabb& box) const {
  std::int32_t node = root_, best = root_;
  const double box_area = area(box);
  double united_area = area(united(nodes_[node].box, box));
  double best_cost = united_area;
  double inherited = 0.0;  // growth of the ancestors of `node`, itself included once it is passed
  while (!nodes_[node].is_leaf()) {
    inherited += united_area - area(nodes_[node].box);
    std::int32_t next = -1;
    double next_bound = 0.0, next_united = 0.0;
    for (const std::int32_t child : nodes_[node].child) {
      const double child_united = area(united(nodes_[child].box, box));
      const double cost = inherited + child_united;
      if (cost < best_cost) {
        best_cost = cost;
        best = child;
      }
      // The least that pairing with a descendant of `child` can cost.
      const double bound = inherited + child_united - area(nodes_[child].box) + box_area;
      if (!nodes_[child].is_leaf() && (next < 0 || bound < next_bound)) {
        next = child;
        next_bound = bound;
        next_united = child_united;
      }
    }
    if (next < 0 || next_bound >= best_cost) break;
    node = next;
    united_area = next_united;
  }
  return best;
}

std::int32_t AabbTree::insert(const Aabb& box, std::int32_t user) {
  const std::int32_t leaf = allocate();
  nodes_[leaf].box = box;
  nodes_[leaf].user = user;
  ++leaves_;
  if (root_ < 0) {
    root_ = leaf;
    return leaf;
  }
  const std::int32_t sibling = best_sibling(box);
  const std::int32_t inner = allocate();
  const std::int32_t parent = nodes_[sibling].parent;
  nodes_[inner].parent = parent;
  nodes_[inner].child[0] = sibling;
  nodes_[inner].child[1] = leaf;
  nodes_[sibling].parent = inner;
  nodes_[leaf].parent = inner;
  if (parent < 0) {
    root_ = inner;
  } else {
    nodes_[parent].child[nodes_[parent].child[0] == sibling ? 0 : 1] = inner;
  }
  refit_from(inner);
  return leaf;
}

void AabbTree::remove(std::int32_t leaf) {
  --leaves_;
  const std::int32_t parent = nodes_[leaf].parent;
  release(leaf);
  if (parent < 0) {
    root_ = -1;
    return;
  }
  const std::int32_t sibling = nodes_[parent].child[nodes_[parent].child[0] == leaf ? 1 : 0];
  const std::int32_t grandparent = nodes_[parent].parent;
  release(parent);
  nodes_[sibling].parent = grandparent;
  if (grandparent < 0) {
    root_ = sibling;
    return;
  }
  nodes_[grandparent].child[nodes_[grandparent].child[0] == parent ? 0 : 1] = sibling;
  refit_from(grandparent);
}

void AabbTree::refit_from(std::int32_t node) {
  for (; node >= 0; node = nodes_[node].parent) {
    Node& n = nodes_[node];
    n.box = united(nodes_[n.child[0]].box, nodes_[n.child[1]].box);
    rotate(node);
  }
}

// Exchanges a child of `node` with a grandchild on the other side when that shrinks the inner box
// in between. The box of `node` itself stays.
void AabbTree::rotate(std::int32_t node) {
  double best_gain = 0.0;
  int best_side = -1, best_slot = -1;
  for (int side = 0; side < 2; ++side) {
    const Node& inner = nodes_[nodes_[node].child[side]];
    if (inner.is_leaf()) continue;
    const Aabb& other = nodes_[nodes_[node].child[1 - side]].box;
    const double before = area(inner.box);
    for (int slot = 0; slot < 2; ++slot) {
      // Grandchild `slot` goes up; the other one stays beside the child that comes down.
      const double gain = before - area(united(nodes_[inner.child[1 - slot]].box, other));
      if (gain > best_gain) {
        best_gain = gain;
        best_side = side;
        best_slot = slot;
      }
    }
  }
  if (best_side < 0) return;
  const std::int32_t inner = nodes_[node].child[best_side];
  const std::int32_t down = nodes_[node].child[1 - best_side];
  const std::int32_t up = nodes_[inner].child[best_slot];
  nodes_[node].child[1 - best_side] = up;
  nodes_[inner].child[best_slot] = down;
  nodes_[up].parent = node;
  nodes_[down].parent = inner;
  nodes_[inner].box =
      united(nodes_[nodes_[inner].child[0]].box, nodes_[nodes_[inner].child[1]].box);
}

int AabbTree::height() const {
  int highest = 0;
  for (const Node& n : nodes_) {
    if (n.user < 0) continue;
    int depth = 0;
    for (std::int32_t p = n.parent; p >= 0; p = nodes_[p].parent) ++depth;
    highest = std::max(highest, depth);
  }
  return highest;
}

double AabbTree::surface_sum() const {
  double sum = 0.0;
  walk(
      [&](const Aabb& b) {
        sum += 2.0 * area(b);
        return true;
      },
      [&](std::int32_t) {});
  // The walk passes leaves too; only inner nodes cost.
  for (const Node& n : nodes_) {
    if (n.user >= 0) sum -= 2.0 * area(n.box);
  }
  return sum;
}

}  // namespace rb
