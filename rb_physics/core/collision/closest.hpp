// Closest points of lines and segments (Ericson 2005, section 5.1).
#pragma once

#include <algorithm>
#include <cmath>

#include "math/types.hpp"

namespace rb {

// Of two lines, point + unit direction, not parallel.
inline void closest_on_lines(const Vec3& p, const Vec3& u, const Vec3& q, const Vec3& v, Vec3& on_p,
                             Vec3& on_q) {
  const Vec3 r = p - q;
  const double b = u.dot(v), d = u.dot(r), e = v.dot(r);
  const double sine_sq = u.cross(v).squaredNorm();
  on_p = p + ((b * e - d) / sine_sq) * u;
  on_q = q + ((e - b * d) / sine_sq) * v;
}

// The parameter in [-half, half] of the point of the segment center + t * axis nearest to `p`.
inline double closest_on_segment(const Vec3& center, const Vec3& axis, double half, const Vec3& p) {
  return std::clamp(axis.dot(p - center), -half, half);
}

struct SegmentParameters {
  double s;  // m along the first, from its centre
  double t;  // m along the second
};

// Nearest points of two segments center + s * axis, |s| <= half. Parallel ones give the middle of
// where they lie side by side.
inline SegmentParameters closest_on_segments(const Vec3& p, const Vec3& u, double half_p,
                                             const Vec3& q, const Vec3& v, double half_q) {
  const Vec3 r = p - q;
  const double b = u.dot(v), d = u.dot(r), e = v.dot(r);
  const double sine_sq = u.cross(v).squaredNorm();
  double s;
  if (sine_sq > 1e-24) {
    s = std::clamp((b * e - d) / sine_sq, -half_p, half_p);
  } else {
    const double middle = -d, reach = half_q;  // of the second, along u from p
    s = 0.5 *
        (std::clamp(middle - reach, -half_p, half_p) + std::clamp(middle + reach, -half_p, half_p));
  }
  double t = b * s + e;
  if (std::abs(t) > half_q) {
    t = std::clamp(t, -half_q, half_q);
    s = std::clamp(b * t - d, -half_p, half_p);
  }
  return {s, t};
}

}  // namespace rb
