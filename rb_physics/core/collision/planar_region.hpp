// A flat convex part of a surface: a whole plane, a polygon, or the cap of a cylinder.
#pragma once

#include <algorithm>
#include <cmath>

#include "collision/face_polygon.hpp"
#include "math/types.hpp"

namespace rb {

struct PlanarRegion {
  Vec3 normal;  // unit, outward
  Vec3 origin;  // m, on the plane; the centre of a disc
  std::uint32_t feature = 0;
  const FacePolygon* polygon = nullptr;  // else
  double radius = 0.0;                   // m, of a disc; else 0: the whole plane

  double height(const Vec3& p) const { return normal.dot(p - origin); }

  // Is p over the region, to `tolerance` (m)?
  bool under(const Vec3& p, double tolerance) const {
    if (polygon) {
      for (int i = 0; i < polygon->size; ++i) {
        if (outward(i).dot(p - polygon->corners[i].point) > tolerance) return false;
      }
      return true;
    }
    if (radius > 0.0) return across(p).norm() <= radius + tolerance;
    return true;
  }

  // The part of the segment p + t (q - p), t in [low, high], over the region. False: none.
  bool clip(const Vec3& p, const Vec3& q, double tolerance, double& low, double& high) const {
    if (polygon) {
      for (int i = 0; i < polygon->size; ++i) {
        const Vec3 out = outward(i);
        const double start = out.dot(p - polygon->corners[i].point);
        const double slope = out.dot(q - p);
        if (std::max(start + low * slope, start + high * slope) <= tolerance) continue;
        if (std::min(start + low * slope, start + high * slope) > tolerance) return false;
        const double crossing = -start / slope;
        if (slope > 0.0) {
          high = std::min(high, crossing);
        } else {
          low = std::max(low, crossing);
        }
      }
      return low <= high;
    }
    if (radius > 0.0) {
      const Vec3 from = across(p), along = across(q) - from;
      const double a = along.squaredNorm(), b = from.dot(along);
      const double c = from.squaredNorm() - radius * radius;
      if (!(a > tolerance * tolerance)) return c <= 2.0 * radius * tolerance;
      const double inside = b * b - a * c;
      if (inside < 0.0) return c <= 2.0 * radius * tolerance;
      const double root = std::sqrt(inside), slack = tolerance / std::sqrt(a);
      const double enter = (-b - root) / a, leave = (-b + root) / a;
      if (enter > low + slack) low = enter;
      if (leave < high - slack) high = leave;
      return low <= high + slack;
    }
    return true;
  }

 private:
  Vec3 outward(int side) const {
    const Vec3& corner = polygon->corners[side].point;
    const Vec3& next = polygon->corners[side + 1 == polygon->size ? 0 : side + 1].point;
    return (next - corner).cross(normal).normalized();
  }
  Vec3 across(const Vec3& p) const {
    const Vec3 d = p - origin;
    return d - normal.dot(d) * normal;
  }
};

}  // namespace rb
