// The contact points of two convex shapes, in a frame near them: axes of the world, origin at one
// of the two. Positions stay small there, so that far from the world's origin nothing is lost.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <utility>

#include "collision/contact_point.hpp"
#include "collision/feature.hpp"
#include "math/types.hpp"

namespace rb {

// A body frame as the narrow phase uses it.
struct Placement {
  Mat3 rotation = Mat3::Identity();
  Vec3 position = Vec3::Zero();  // m

  Vec3 apply(const Vec3& local) const { return rotation * local + position; }
  Vec3 apply_inverse(const Vec3& p) const { return rotation.transpose() * (p - position); }
  Placement operator*(const Pose& child) const {
    return {rotation * child.orientation.toRotationMatrix(), apply(child.position)};
  }
};

struct ManifoldPoint {
  Vec3 point_a;  // m
  Vec3 point_b;  // m
  Vec3 normal;   // unit, from B to A
  double separation = 0.0;
  std::uint32_t feature_a = 0;
  std::uint32_t feature_b = 0;
  ContactKind kind = ContactKind::SMOOTH;
  NormalOwner normal_owner = NormalOwner::CENTERS;
};

// The same contact with A and B exchanged.
inline ManifoldPoint mirrored(const ManifoldPoint& p) {
  const NormalOwner owner = p.normal_owner == NormalOwner::A   ? NormalOwner::B
                            : p.normal_owner == NormalOwner::B ? NormalOwner::A
                                                               : p.normal_owner;
  return {p.point_b, p.point_a, -p.normal, p.separation, p.feature_b, p.feature_a, p.kind, owner};
}

class Manifold {
 public:
  static constexpr int capacity = 8;

  int size() const { return size_; }
  ManifoldPoint& operator[](int i) { return points_[i]; }
  const ManifoldPoint& operator[](int i) const { return points_[i]; }
  void clear() { size_ = 0; }
  void truncate(int size) { size_ = size; }
  // Of the points from `first` on, m; infinite when there are none.
  double least_separation(int first) const {
    double least = std::numeric_limits<double>::infinity();
    for (int i = first; i < size_; ++i) least = std::min(least, points_[i].separation);
    return least;
  }
  void add(const ManifoldPoint& point) {
    if (size_ < capacity) points_[size_++] = point;
  }

  // The same contacts with A and B exchanged.
  void mirror() {
    for (int i = 0; i < size_; ++i) points_[i] = mirrored(points_[i]);
  }

 private:
  std::array<ManifoldPoint, capacity> points_;
  int size_ = 0;
};

}  // namespace rb
