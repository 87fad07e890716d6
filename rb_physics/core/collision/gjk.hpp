// Distance of two convex sets by the Gilbert-Johnson-Keerthi algorithm (van den Bergen 2003).
// A set is given by its support mapping: SimplexPoint support(direction), the farthest point that
// way.
#pragma once

#include <cmath>

#include "collision/simplex.hpp"
#include "math/types.hpp"

namespace rb {

struct SupportPoint {
  Vec3 point;
  int index = 0;
};

// The farthest point along d, searched from the vertex `start` where the set has vertices.
template <class Support>
SupportPoint support_from(const Support& support, const Vec3& d, int start) {
  if constexpr (requires { support.from(d, start); }) {
    return support.from(d, start);
  } else {
    return support(d);
  }
}

enum class GjkStatus {
  SEPARATED,  // nearest points found
  BEYOND,     // farther apart than asked about
  OVERLAP,    // the sets meet, or are too close to tell
  CAPPED,     // iterations ran out; the answer is the best found
};

struct GjkResult {
  GjkStatus status = GjkStatus::OVERLAP;
  Simplex simplex;           // of the nearest points, or around the origin
  Vec3 toward_a;             // m, nearest point on A minus nearest point on B
  double distance = 0.0;     // m
  double lower_bound = 0.0;  // m, proven
  int iterations = 0;
};

// `direction` is a first guess of A - B. Sets farther apart than `beyond` (m) are only proven to
// be. Closer than `zero` (m) counts as overlap. `relative` is the gap allowed between the distance
// and its lower bound.
template <class SupportA, class SupportB>
GjkResult gjk(const SupportA& support_a, const SupportB& support_b, const Vec3& direction,
              double beyond, double zero, double relative = 1e-15, double absolute = 0.0) {
  constexpr int max_iterations = 200;  // polytopes need about ten, smooth sets some dozens
  GjkResult result;
  Simplex& simplex = result.simplex;
  const auto difference = [&](const Vec3& d) {
    const SupportPoint a = support_a(Vec3(-d)), b = support_b(d);
    return SimplexVertex{a.point - b.point, a.point, b.point, a.index, b.index};
  };
  Vec3 v = direction;
  if (!(v.squaredNorm() > 0.0)) v = Vec3::UnitX();
  simplex.vertex[0] = difference(v);
  simplex.weight[0] = 1.0;
  simplex.size = 1;
  v = simplex.vertex[0].w;
  double v_sq = v.squaredNorm();
  const double zero_sq = zero * zero;
  for (int i = 1; i <= max_iterations; ++i) {
    result.iterations = i;
    if (v_sq <= zero_sq) {
      result.status = GjkStatus::OVERLAP;
      return result;
    }
    const SimplexVertex next = difference(v);
    const double reach = v.dot(next.w);
    const double length = std::sqrt(v_sq);
    result.lower_bound = std::max(result.lower_bound, reach / length);
    if (result.lower_bound > beyond) {
      result.status = GjkStatus::BEYOND;
      result.toward_a = v;
      result.distance = length;
      return result;
    }
    result.status = GjkStatus::SEPARATED;
    result.toward_a = v;
    result.distance = length;
    if (v_sq - reach <= relative * v_sq + absolute * length || simplex.contains(next.w))
      return result;
    simplex.vertex[simplex.size++] = next;
    const Simplex::Step step = simplex.reduce_to_nearest(v_sq);
    if (step == Simplex::Step::INSIDE) {
      result.status = GjkStatus::OVERLAP;
      return result;
    }
    if (step == Simplex::Step::STUCK) return result;  // rounding: no progress is left
    v = simplex.nearest();
    v_sq = v.squaredNorm();
  }
  result.status = GjkStatus::CAPPED;
  result.toward_a = v;
  result.distance = std::sqrt(v_sq);
  return result;
}

}  // namespace rb
