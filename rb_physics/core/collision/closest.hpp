// Closest points of lines and segments (Ericson 2005, section 5.1).
#pragma once

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

}  // namespace rb
