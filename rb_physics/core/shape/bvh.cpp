#include "shape/bvh.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace rb {

Bvh::Bvh(const std::vector<Aabb>& boxes) {
  if (boxes.empty()) return;
  std::vector<std::int32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0);
  nodes_.reserve(2 * boxes.size());
  build(boxes, order, 0, static_cast<std::int32_t>(order.size()));
}

void Bvh::build(const std::vector<Aabb>& boxes, std::vector<std::int32_t>& order,
                std::int32_t first, std::int32_t last) {
  Aabb all = boxes[order[first]];
  for (std::int32_t i = first + 1; i < last; ++i) {
    all.lower = all.lower.cwiseMin(boxes[order[i]].lower);
    all.upper = all.upper.cwiseMax(boxes[order[i]].upper);
  }
  const std::size_t node = nodes_.size();
  nodes_.push_back({all, 0, last - first == 1 ? order[first] : -1});
  if (last - first > 1) {
    int axis = 0;
    (all.upper - all.lower).maxCoeff(&axis);
    const auto middle = [&](std::int32_t i) { return boxes[i].lower[axis] + boxes[i].upper[axis]; };
    const std::int32_t half = first + (last - first) / 2;
    std::nth_element(order.begin() + first, order.begin() + half, order.begin() + last,
                     [&](std::int32_t i, std::int32_t j) {
                       return std::pair(middle(i), i) < std::pair(middle(j), j);
                     });
    build(boxes, order, first, half);
    build(boxes, order, half, last);
  }
  nodes_[node].end = static_cast<std::int32_t>(nodes_.size());
}

bool ray_meets(const Aabb& box, const Vec3& origin, const Vec3& direction, double t_max) {
  double enter = 0.0, leave = t_max;
  for (int k = 0; k < 3; ++k) {
    if (direction[k] == 0.0) {
      if (origin[k] < box.lower[k] || origin[k] > box.upper[k]) return false;
      continue;
    }
    double near = (box.lower[k] - origin[k]) / direction[k];
    double far = (box.upper[k] - origin[k]) / direction[k];
    if (near > far) std::swap(near, far);
    // A few ulp of room: the slabs are rounded, and what lies inside may touch the box.
    near -= 4e-15 * std::abs(near);
    far += 4e-15 * std::abs(far);
    enter = std::max(enter, near);
    leave = std::min(leave, far);
    if (enter > leave) return false;
  }
  return true;
}

}  // namespace rb
