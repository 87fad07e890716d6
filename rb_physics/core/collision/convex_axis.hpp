// The axis along which two convex sets are farthest apart or overlap least, by GJK or EPA.
#pragma once

#include <algorithm>
#include <cmath>

#include "collision/epa.hpp"
#include "collision/gjk.hpp"
#include "collision/iteration_caps.hpp"
#include "math/tolerances.hpp"

namespace rb {

struct ConvexAxis {
  bool beyond = false;      // farther apart than asked about
  double separation = 0.0;  // m
  Vec3 normal;              // unit, from B to A
  bool apart = false;       // a positive distance was found, and points that far apart
  bool certain = false;     // apart, and the nearest points are exact
  bool least = true;        // of an overlap: no axis is known to be missing that parts sooner
  Vec3 on_a, on_b;          // m, nearest points when apart
};

// A: support and curvature(n, m, k); B the same.
template <class A, class B>
class AxisSearch {
 public:
  AxisSearch(const A& a, const B& b, double size) : a_(a), b_(b), size_(size) {}

  double separation(const Vec3& n) const { return n.dot(a_(Vec3(-n)).point - b_(n).point); }

  // Distance or penetration within about 1e-10 of `size`, unless `least` says otherwise.
  ConvexAxis first(const Vec3& direction, double beyond) const {
    ConvexAxis axis;
    const double close = 1e-9 * size_;
    const GjkResult nearest = gjk(a_, b_, direction, beyond, close, 1e-14, 1e-13 * size_);
    if (nearest.status == GjkStatus::BEYOND) {
      axis.beyond = true;
      return axis;
    }
    if (nearest.status == GjkStatus::CAPPED) count_iteration_cap();
    if (nearest.status != GjkStatus::OVERLAP) {
      axis.normal = nearest.toward_a / nearest.distance;
      axis.separation = nearest.distance;
      axis.apart = true;
      axis.on_a = nearest.simplex.nearest_on_a();
      axis.on_b = nearest.simplex.nearest_on_b();
      // Very unequal sizes leave GJK with slivers: then only what the direction proves counts.
      const double proven = separation(axis.normal);
      axis.certain = axis.separation - proven <= 1e-11 * size_;
      if (!axis.certain) axis.separation = proven;
      if (axis.certain || proven > tolerance::closest_direction * size_) return axis;
      // So near to contact that GJK ran into rounding: its points are none to go by. Does EPA know
      // a better direction?
      axis.apart = false;
      const EpaResult overlap = epa(a_, b_, Simplex{}, 1e-10 * size_);
      axis.least = !overlap.capped && overlap.gap <= 1e-9 * size_;
      if (overlap.capped || -overlap.depth <= proven) return axis;
      axis.normal = overlap.normal;
      axis.separation = -overlap.depth;
      return axis;
    }
    EpaResult overlap = epa(a_, b_, nearest.simplex, 1e-10 * size_);
    if (overlap.capped || overlap.gap > 1e-9 * size_) {
      // A sliver to start from, or one met on the way: once more from far points. Any depth found
      // is one that parts the sets, so the lesser is the better.
      const EpaResult again = epa(a_, b_, Simplex{}, 1e-10 * size_);
      if (again.depth < overlap.depth) overlap = again;
      // Touching faces can leave both with no proper polytope.
      axis.least = !overlap.capped && overlap.gap <= 1e-9 * size_;
    }
    axis.normal = overlap.normal;
    axis.separation = -overlap.depth;
    return axis;
  }

  // The direction near `start` at which the separation is greatest, where it is smooth: Newton's
  // method over unit vectors. Near the end the separation only carries rounding; then the slope
  // tells which direction is better.
  Vec3 refined(const Vec3& start) const {
    Vec3 n = start;
    Tangent at = tangent(n);
    for (int i = 0; i < 60 && at.slope > 0.0; ++i) {
      double mm = -at.separation - a_.curvature(n, at.m, at.m) - b_.curvature(n, at.m, at.m);
      const double mk = -a_.curvature(n, at.m, at.k) - b_.curvature(n, at.m, at.k);
      double kk = -at.separation - a_.curvature(n, at.k, at.k) - b_.curvature(n, at.k, at.k);
      // Where the separation does not bend down every way (rims side by side), a shorter step.
      const double half_sum = 0.5 * (mm + kk), half_gap = 0.5 * (mm - kk);
      const double spread = std::sqrt(half_gap * half_gap + mk * mk);
      const double least = 1e-4 * (std::abs(half_sum) + spread);
      const double shift = std::max(0.0, half_sum + spread + least);
      mm -= shift;
      kk -= shift;
      const double det = mm * kk - mk * mk;
      if (!(det > 0.0)) break;
      Vec3 step =
          -((kk * at.gm - mk * at.gk) / det) * at.m - ((mm * at.gk - mk * at.gm) / det) * at.k;
      bool better = false;
      for (int halvings = 0; halvings < 8 && !better; ++halvings, step *= 0.5) {
        const Vec3 next = (n + step).normalized();
        const Tangent there = tangent(next);
        const double noise = 1e-15 * (std::abs(at.separation) + size_);
        better = there.separation > at.separation + noise ||
                 (there.separation >= at.separation - noise && there.slope < at.slope);
        if (better) n = next, at = there;
      }
      if (!better) break;
    }
    return n;
  }

 private:
  // The separation and its slope along two tangents m, k.
  struct Tangent {
    Vec3 m, k;
    double separation, gm, gk, slope;
  };
  Tangent tangent(const Vec3& n) const {
    const Vec3 m = n.unitOrthogonal(), k = n.cross(m);
    const Vec3 w = a_(Vec3(-n)).point - b_(n).point;
    const double gm = m.dot(w), gk = k.dot(w);
    return {m, k, n.dot(w), gm, gk, std::sqrt(gm * gm + gk * gk)};
  }

  const A& a_;
  const B& b_;
  double size_;
};

}  // namespace rb
