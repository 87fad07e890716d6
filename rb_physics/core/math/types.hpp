// The vocabulary of the core: double-precision vectors, matrices, quaternions, rigid transforms.
// SI units, right-handed, z up (REP 103). Quaternions are (x, y, z, w) at every interface.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

namespace rb {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat3 = Eigen::Matrix3d;
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Quat = Eigen::Quaterniond;

// A rigid transform: x_parent = orientation * x_local + position.
struct Pose {
  Vec3 position = Vec3::Zero();         // m
  Quat orientation = Quat::Identity();  // unit

  Vec3 apply(const Vec3& local) const { return orientation * local + position; }
  Vec3 apply_inverse(const Vec3& parent) const {
    return orientation.conjugate() * (parent - position);
  }
  Vec3 rotate(const Vec3& local) const { return orientation * local; }
  Vec3 rotate_inverse(const Vec3& parent) const { return orientation.conjugate() * parent; }

  Pose operator*(const Pose& child) const {
    return {apply(child.position), orientation * child.orientation};
  }
  Pose inverse() const {
    const Quat q = orientation.conjugate();
    return {q * (-position), q};
  }
};

// Axis-aligned bounding box, m.
struct Aabb {
  Vec3 lower;
  Vec3 upper;

  bool overlaps(const Aabb& other) const {
    return (lower.array() <= other.upper.array()).all() &&
           (other.lower.array() <= upper.array()).all();
  }
};

}  // namespace rb
