// The axis along which two convex sets are farthest apart or overlap least, to rounding: GJK or EPA
// gives a first answer, which is then moved to the maximum of the separation over directions.
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "collision/epa.hpp"
#include "collision/gjk.hpp"
#include "collision/iteration_caps.hpp"
#include "math/tolerances.hpp"

namespace rb {

struct ConvexAxis {
  bool beyond = false;      // farther apart than asked about
  double separation = 0.0;  // m
  Vec3 normal;              // unit, from B to A
  bool fixed = false;       // a direction offered by the shapes themselves
  bool apart = false;       // a positive distance was found
  bool certain = false;     // apart, and the nearest points are exact
  Vec3 on_a, on_b;          // m, nearest points when apart
};

// A: support and curvature(n, m, k); B the same.
template <class A, class B>
class AxisSearch {
 public:
  AxisSearch(const A& a, const B& b, double size) : a_(a), b_(b), size_(size) {}

  double separation(const Vec3& n) const { return n.dot(a_(Vec3(-n)).point - b_(n).point); }

  // Distance or penetration within about 1e-10 of `size`.
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
      return axis;
    }
    EpaResult overlap = epa(a_, b_, nearest.simplex, 1e-10 * size_);
    if (overlap.capped || overlap.gap > 1e-9 * size_) {
      // A sliver to start from, or one met on the way: once more from far points. Any depth found
      // is one that parts the sets, so the lesser is the better.
      const EpaResult again = epa(a_, b_, Simplex{}, 1e-10 * size_);
      if (again.capped) count_iteration_cap();
      if (again.depth < overlap.depth) overlap = again;
    }
    axis.normal = overlap.normal;
    axis.separation = -overlap.depth;
    return axis;
  }

  // Takes a direction of the shapes (a face normal, a cap, a product of edges) where it separates
  // as well as the axis does.
  void offer(const Vec3& n, ConvexAxis& axis) const {
    const double s = separation(n);
    const double preference = tolerance::axis_preference * size_;
    const bool wins =
        axis.fixed ? s > axis.separation + preference : s >= axis.separation - preference;
    if (!wins) return;
    axis.normal = n;
    axis.separation = s;
    axis.fixed = true;
  }

  // Newton's method for the separation over unit vectors.
  void refine(ConvexAxis& axis) const { climb(axis.normal, axis); }

  // The same among the directions perpendicular to `edge`.
  void refine_across(const Vec3& edge, ConvexAxis& axis) const {
    const Vec3 e = edge.normalized();
    Vec3 n = axis.normal - e.dot(axis.normal) * e;
    const double length = n.norm();
    if (!(length > 0.5)) return;
    n /= length;
    double s = separation(n);
    for (int i = 0; i < 12; ++i) {
      const Vec3 m = e.cross(n);
      const double slope = m.dot(a_(Vec3(-n)).point - b_(n).point);
      const double bend = -s - a_.curvature(n, m, m) - b_.curvature(n, m, m);
      if (!(bend < 0.0)) break;
      const Vec3 next = (n - (slope / bend) * m).normalized();
      const double s_next = separation(next);
      if (!(s_next > s)) break;
      n = next;
      s = s_next;
    }
    take(n, s, axis);
  }

 private:
  void climb(const Vec3& start, ConvexAxis& axis) const {
    Vec3 n = start;
    double s = separation(n);
    for (int i = 0; i < 12; ++i) {
      const Vec3 m = n.unitOrthogonal(), k = n.cross(m);
      const Vec3 w = a_(Vec3(-n)).point - b_(n).point;
      const double gm = m.dot(w), gk = k.dot(w);
      const double mm = -s - a_.curvature(n, m, m) - b_.curvature(n, m, m);
      const double mk = -a_.curvature(n, m, k) - b_.curvature(n, m, k);
      const double kk = -s - a_.curvature(n, k, k) - b_.curvature(n, k, k);
      const double det = mm * kk - mk * mk;
      if (!(det > 0.0) || !(mm + kk < 0.0)) break;
      const Vec3 next =
          (n - ((kk * gm - mk * gk) / det) * m - ((mm * gk - mk * gm) / det) * k).normalized();
      const double s_next = separation(next);
      if (!(s_next > s)) break;
      n = next;
      s = s_next;
    }
    take(n, s, axis);
  }

  void take(const Vec3& n, double s, ConvexAxis& axis) const {
    if (axis.fixed || !(s > axis.separation) || axis.certain) return;
    axis.normal = n;
    axis.separation = s;
  }

  const A& a_;
  const B& b_;
  double size_;
};

}  // namespace rb
