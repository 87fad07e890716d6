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

  SupportPoint operator()(const Vec3& d) const {
    const double along = axis.dot(d);
    const Vec3 radial = d - along * axis;
    const double length = radial.norm();
    const Vec3 cap = cap_center(along >= 0.0);
    if (!(length > 1e-14 * std::abs(along))) return {cap, 0};
    return {cap + (radius / length) * radial, 0};
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
