// Walks over the pairs of convex leaves of two shapes that may be compounds.
#pragma once

#include <limits>
#include <vector>

#include "collision/canonical_order.hpp"
#include "collision/leaf_contacts.hpp"
#include "collision/manifold.hpp"
#include "collision/surface_contacts.hpp"
#include "shape/shape.hpp"

namespace rb {

// A leaf of a shape: the shape itself or one part of a compound, and its pose.
struct Leaf {
  const Shape* shape;
  Pose pose;
  std::uint32_t part;
};

inline int leaf_count(const Shape& shape) {
  const auto* compound = std::get_if<Compound>(&shape);
  return compound ? static_cast<int>(compound->data->parts.size()) : 1;
}

inline Leaf leaf(const Shape& shape, const Pose& pose, int part) {
  const auto* compound = std::get_if<Compound>(&shape);
  if (!compound) return {&shape, pose, 0};
  const CompoundPart& inner = compound->data->parts[part];
  return {&inner.shape, pose * inner.pose, static_cast<std::uint32_t>(part)};
}

// A ball looks the same from everywhere: its axes are not worked out.
inline Placement placement_of(const Shape& shape, const Pose& pose) {
  const bool ball =
      std::holds_alternative<Sphere>(shape) || std::holds_alternative<Particle>(shape);
  return {ball ? Mat3(Mat3::Identity()) : Mat3(pose.orientation.toRotationMatrix()), pose.position};
}

// Contacts of two leaves, A and B as given.
inline void ordered_leaf_contacts(const Leaf& a, const Leaf& b, double margin, Manifold& out) {
  const Placement at_a = placement_of(*a.shape, a.pose), at_b = placement_of(*b.shape, b.pose);
  if (comes_second(*a.shape, a.pose, *b.shape, b.pose)) {
    leaf_contacts(*b.shape, at_b, *a.shape, at_a, margin, out);
    out.mirror();
  } else {
    leaf_contacts(*a.shape, at_a, *b.shape, at_b, margin, out);
  }
}

// Contacts of a convex leaf with a mesh or height field; for an infinite margin the nearest points.
inline std::vector<Manifold> surface_manifolds(const Leaf& convex, const Leaf& surface,
                                               double margin) {
  std::vector<Manifold> manifolds;
  const bool nearest_only = margin == std::numeric_limits<double>::infinity();
  SurfaceDistance nearest{};
  if (nearest_only) {
    nearest = surface_distance(*convex.shape, convex.pose, *surface.shape, surface.pose);
    margin = 0.0;
  }
  if (!nearest_only || nearest.distance <= 0.0) {
    surface_contacts(*convex.shape, convex.pose, *surface.shape, surface.pose, margin, manifolds);
  }
  if (nearest_only && manifolds.empty()) {
    manifolds.emplace_back();
    manifolds.back().add(nearest.nearest);
  }
  return manifolds;
}

// Calls visit(manifold, origin) for every pair of leaves that has contacts with separation <=
// margin. Points of the manifold are relative to `origin` (m, world); A and B are the caller's.
template <class Visit>
void for_each_leaf_manifold(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                            double margin, const Visit& visit) {
  static thread_local Manifold memory;
  Manifold& manifold = memory;
  // The origin is the position of whichever body comes second, so that exchanging A and B changes
  // no bit of the arithmetic.
  const bool swap = comes_second(a, pose_a, b, pose_b);
  const Shape& first = swap ? b : a;
  const Shape& second = swap ? a : b;
  const Pose& world_1 = swap ? pose_b : pose_a;
  const Pose& world_2 = swap ? pose_a : pose_b;
  const Vec3& origin = world_2.position;
  const Pose pose_1{world_1.position - origin, world_1.orientation};
  const Pose pose_2{Vec3::Zero(), world_2.orientation};
  const auto is_leaf = [](const Shape& s) {
    return !std::holds_alternative<Compound>(s) && !is_surface(s);
  };
  if (is_leaf(first) && is_leaf(second)) {
    manifold.clear();
    leaf_contacts(first, placement_of(first, pose_1), second, placement_of(second, pose_2), margin,
                  manifold);
    if (swap) manifold.mirror();
    if (manifold.size() > 0) visit(manifold, origin);
    return;
  }
  const int count_1 = leaf_count(first), count_2 = leaf_count(second);
  for (int i = 0; i < count_1; ++i) {
    const Leaf leaf_1 = leaf(first, pose_1, i);
    const Aabb box_1 = bounding_box(*leaf_1.shape, leaf_1.pose);
    for (int j = 0; j < count_2; ++j) {
      const Leaf leaf_2 = leaf(second, pose_2, j);
      Aabb box_2 = bounding_box(*leaf_2.shape, leaf_2.pose);
      box_2.lower.array() -= margin;
      box_2.upper.array() += margin;
      if (!box_1.overlaps(box_2)) continue;
      const auto finish = [&](Manifold& found) {
        if (found.size() == 0) return;
        for (int k = 0; k < found.size(); ++k) {
          found[k].feature_a = with_part(found[k].feature_a, leaf_1.part);
          found[k].feature_b = with_part(found[k].feature_b, leaf_2.part);
        }
        if (swap) found.mirror();
        visit(found, origin);
      };
      if (is_surface(*leaf_2.shape) || is_surface(*leaf_1.shape)) {
        for (Manifold& found : surface_manifolds(leaf_1, leaf_2, margin)) finish(found);
        continue;
      }
      manifold.clear();
      ordered_leaf_contacts(leaf_1, leaf_2, margin, manifold);
      finish(manifold);
    }
  }
}

}  // namespace rb
