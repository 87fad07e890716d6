// A placed cylinder: support mapping, curvature of its support function, numbered rim points.
#pragma once

#include <array>
#include <cmath>

#include "collision/gjk.hpp"
#include "collision/manifold.hpp"
#include "math/tolerances.hpp"
#include "shape/shape.hpp"

namespace rb {

struct PlacedCylinder {
  Vec3 center, axis, x, y;
  double radius, half;

  PlacedCylinder(const Cylinder& shape, const Placement& at)
      : center(at.position),
        axis(at.rotation.col(2)),
        x(at.rotation.col(0)),
        y(at.rotation.col(1)),
        radius(shape.radius),
        half(shape.half_length) {}

  double size() const { return std::max(radius, half); }
  Vec3 cap_center(bool upper) const { return center + (upper ? half : -half) * axis; }
  Vec3 cap_normal(bool upper) const { return upper ? axis : Vec3(-axis); }
  Vec3 across(const Vec3& d) const { return d - axis.dot(d) * axis; }
  // Unit vector of the part of d across the axis; false within rounding of the axis. Little is left
  // of a steep d: once more makes that little perpendicular to its own rounding.
  bool radial(const Vec3& d, Vec3& direction) const {
    const double along = axis.dot(d);
    direction = d - along * axis;
    double length_sq = direction.squaredNorm();
    if (length_sq < 1e-6 * along * along) {
      direction = across(direction);
      length_sq = direction.squaredNorm();
      if (!(length_sq > 1e-28 * along * along)) return false;
    }
    if (!(length_sq > 0.0)) return false;
    direction /= std::sqrt(length_sq);
    return true;
  }

  SupportPoint operator()(const Vec3& d) const {
    const Vec3 cap = cap_center(axis.dot(d) >= 0.0);
    Vec3 direction;
    if (!radial(d, direction)) return {cap, 0};
    return {cap + radius * direction, 0};
  }

  // What of the cylinder lies farthest along the unit vector d.
  enum class Part { CAP, SIDE, RIM };
  Part part_facing(const Vec3& d) const {
    const double along = axis.dot(d);
    if (std::abs(along) <= tolerance::parallel) return Part::SIDE;
    if ((d - along * axis).squaredNorm() <= tolerance::parallel * tolerance::parallel) {
      return Part::CAP;
    }
    return Part::RIM;
  }

  // Second derivative of the support function at the unit vector n along tangents m, k.
  double curvature(const Vec3& n, const Vec3& m, const Vec3& k) const {
    const Vec3 pn = across(n);
    const double length_sq = pn.squaredNorm();
    if (!(length_sq > 1e-24)) return 0.0;
    return radius * (across(m).dot(across(k)) - pn.dot(m) * pn.dot(k) / length_sq) /
           std::sqrt(length_sq);
  }

  // Eight fixed points of a rim, every 45 degrees from the body's x axis.
  static constexpr int rim_points = 8;
  Vec3 rim_direction(int k) const {
    constexpr double r = 0.70710678118654752440;
    static constexpr double c[8] = {1, r, 0, -r, -1, -r, 0, r};
    return c[k] * x + c[(k + 6) % 8] * y;
  }
  static std::uint32_t rim_point_feature(bool upper, int k) {
    return make_feature(FeatureType::EDGE, (upper ? 0 : rim_points) + k);
  }
  static std::uint32_t rim_feature(bool upper) {
    return make_feature(FeatureType::SMOOTH, upper ? 0 : 1);
  }
  static std::uint32_t side_feature() { return make_feature(FeatureType::SMOOTH, 2); }
  static std::uint32_t cap_feature(bool upper) {
    return make_feature(FeatureType::FACE, upper ? 0 : 1);
  }
};

}  // namespace rb
