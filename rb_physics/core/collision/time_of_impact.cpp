// The contact time of two moving shapes by certified steps: no impact is stepped over.
//
// For a fixed world axis n the gap f(t) = min n.x over A - max n.x over B is a lower bound of the
// distance, with equality at the time where n is the shapes' normal. Every pair of points' height
// difference along n has a second derivative of at most C = |a| + (omega^2 + alpha) R, summed over
// both bodies, so it lies at most C s (h - s) / 2 below its chord over [0, h], and so does their
// minimum:
//   f(t + s) >= f(t) + (f(t + h) - f(t)) s / h - C s (h - s) / 2.
// Up to the first root of the right side nothing can touch. Near an impact h shrinks with the gap,
// the chord becomes the tangent, and the steps converge from below like Newton's; past a graze of
// depth delta they number about log(1 / delta). (Conservative advancement, Mirtich 1996, uses the
// first derivative only and crawls in both cases.)
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "collision/extent.hpp"
#include "collision/iteration_caps.hpp"
#include "collision/queries.hpp"
#include "collision/surface_contacts.hpp"
#include "collision/sweep.hpp"
#include "shape/compound.hpp"

namespace rb {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

// Radius of what turning about `center` (body coordinates) can move: a ball only by its own centre.
double turning_radius(const Shape& shape, const Vec3& center) {
  if (std::holds_alternative<Sphere>(shape)) return center.norm();
  if (const auto* s = std::get_if<Capsule>(&shape)) {
    return bounding_radius(Capsule{0.0, s->half_length}, center);
  }
  return bounding_radius(shape, center);
}

// Two convex shapes in motion, and the bounds on their relative motion.
class ConvexPair {
 public:
  ConvexPair(const Shape& a, const Sweep& motion_a, const Shape& b, const Sweep& motion_b,
             double t_max)
      : a_(a), b_(b), motion_a_(motion_a), motion_b_(motion_b), t_max_(t_max) {
    const Pose pose_a = motion_a.at(0.0), pose_b = motion_b.at(0.0);
    const Vec3 center_a = motion_a.center(0.0), center_b = motion_b.center(0.0);
    const double path = t_max * max_relative_speed(motion_a, motion_b, 0.0, t_max);
    plane_is_a_ = std::holds_alternative<HalfSpace>(a);
    plane_is_b_ = std::holds_alternative<HalfSpace>(b);
    if (plane_is_a_ && plane_is_b_) {
      throw std::invalid_argument("time_of_impact: two half-spaces have no contact time");
    }
    double radius_a = plane_is_a_ ? 0.0 : bounding_radius(a, pose_a.apply_inverse(center_a));
    double radius_b = plane_is_b_ ? 0.0 : bounding_radius(b, pose_b.apply_inverse(center_b));
    size_ = plane_is_a_ ? radius_b : plane_is_b_ ? radius_a : std::min(radius_a, radius_b);
    if (!plane_is_a_) radius_a = turning_radius(a, pose_a.apply_inverse(center_a));
    if (!plane_is_b_) radius_b = turning_radius(b, pose_b.apply_inverse(center_b));
    // A turning plane moves fastest where the other shape may be.
    const double reach = (center_a - center_b).norm() + path + size_;
    if (plane_is_a_) radius_a = reach;
    if (plane_is_b_) radius_b = reach;
    const double wa = motion_a.max_angular_speed(), wb = motion_b.max_angular_speed();
    turning_speed_ = wa * radius_a + wb * radius_b;
    angular_speed_ = wa + wb;
    arms_ = radius_a + radius_b;
    curvature_ = (motion_a.acceleration() - motion_b.acceleration()).norm() +
                 (wa * wa + motion_a.max_angular_acceleration()) * radius_a +
                 (wb * wb + motion_b.max_angular_acceleration()) * radius_b;
    if (plane_is_a_ || plane_is_b_) {  // the axis turns too: d/dt^2 (m . x) has a Coriolis term
      const double w = plane_is_a_ ? wa : wb;
      const double other = plane_is_a_ ? wb * radius_b : wa * radius_a;
      curvature_ += 2.0 * w * (path / std::max(t_max, 1e-300) + other);
    }
  }

  double t_max() const { return t_max_; }
  double curvature() const { return curvature_; }
  // m, below it a gap is rounding of the positions.
  double rounding(double t) const {
    return 4.0 * epsilon * (motion_a_.center(t).norm() + motion_b_.center(t).norm() + size_);
  }
  // m, size of the smaller shape.
  double size() const { return size_; }
  double speed(double t) const {
    return max_relative_speed(motion_a_, motion_b_, t, t_max_) + turning_speed_;
  }

  bool has_plane() const { return plane_is_a_ || plane_is_b_; }
  double angular_speed() const { return angular_speed_; }
  // The same bound for an axis that turns at `rate` (rad/s): d^2/dt^2 (n . x) has two more terms.
  double curvature(double rate, double t) const {
    const double apart = (motion_a_.center(t) - motion_b_.center(t)).norm() + arms_;
    return curvature_ + 2.0 * rate * speed(t) + rate * rate * apart;
  }

  DistanceResult distance_at(double t) const {
    return distance(a_, motion_a_.at(t), b_, motion_b_.at(t));
  }
  double gap(double t) const { return distance_at(t).distance; }

  // f(t) along the axis n; for a half-space along its own normal, which is the true distance.
  double gap_along(const Vec3& n, double t) const {
    const Pose pose_a = motion_a_.at(t), pose_b = motion_b_.at(t);
    if (plane_is_b_) return above(std::get<HalfSpace>(b_), pose_b, a_, pose_a);
    if (plane_is_a_) return above(std::get<HalfSpace>(a_), pose_a, b_, pose_b);
    return -extent(a_, pose_a, -n) - extent(b_, pose_b, n);
  }

 private:
  static double above(const HalfSpace& plane, const Pose& at, const Shape& other,
                      const Pose& pose) {
    const Vec3 n = at.rotate(plane.normal);
    return -extent(other, pose, -n) - (plane.offset + n.dot(at.position));
  }

  const Shape& a_;
  const Shape& b_;
  const Sweep& motion_a_;
  const Sweep& motion_b_;
  double t_max_;
  bool plane_is_a_, plane_is_b_;
  double size_, turning_speed_, angular_speed_, arms_, curvature_;
};

// First root in (0, h) of f0 + (f1 - f0) s / h - C s (h - s) / 2, or h when it stays positive.
double certified_step(double f0, double f1, double h, double curvature) {
  const double half = 0.5 * curvature;
  const double slope = (f1 - f0) / h - half * h;  // of half s^2 + slope s + f0
  const double discriminant = slope * slope - 4.0 * half * f0;
  if (slope >= 0.0 || discriminant < 0.0) return f1 > 0.0 ? h : h * f0 / (f0 - f1);
  return std::min(h, 2.0 * f0 / (-slope + std::sqrt(discriminant)));
}

// Root of the signed distance in [t0, t1], where it changes sign: bisection made fast by the
// Illinois rule (Dowell & Jarratt 1971).
double bracketed_root(const ConvexPair& pair, double t0, double g0, double t1, double g1,
                      int& count) {
  for (int side = 0, i = 0; i < 100; ++i) {
    double t = (t0 * g1 - t1 * g0) / (g1 - g0);
    if (!(t > t0 && t < t1)) t = 0.5 * (t0 + t1);
    if (!(t > t0 && t < t1)) break;
    const double g = pair.gap(t);
    ++count;
    if (std::abs(g) <= pair.rounding(t)) return t;
    if (g > 0.0) {
      t0 = t, g0 = g;
      if (side == 1) g1 *= 0.5;
      side = 1;
    } else {
      t1 = t, g1 = g;
      if (side == -1) g0 *= 0.5;
      side = -1;
    }
  }
  return t0;
}

class Search {
 public:
  Search(const ConvexPair& pair, int most_queries) : pair_(pair), most_queries_(most_queries) {}

  ImpactSearch run() {
    const double first = query(0.0);
    if (first <= touching() && !part()) return result_;
    while (t_ < pair_.t_max() && !result_.time) {
      if (result_.iterations >= most_queries_) {
        result_.converged = false;
        count_iteration_cap();
        result_.time = t_;
        break;
      }
      const double before = t_;
      advance();
      // Steps below the resolution of time: the gap can't be told from zero.
      if (!result_.time && !(t_ > before)) result_.time = t_;
    }
    return result_;
  }

 private:
  double touching() const { return std::max(1e-12 * pair_.size(), 8.0 * pair_.rounding(t_)); }

  double query(double t) {
    ++result_.iterations;
    nearest_ = pair_.distance_at(t);
    return nearest_.distance;
  }

  // The shapes touch or overlap at 0. True when they have parted at the new t_; else the search is
  // over: an impact at 0 when they sink in, nothing when they rest.
  bool part() {
    const double start = nearest_.distance;
    // Deeper or shallower by this much is motion, not noise.
    const double noise = std::max(touching(), 1e-10 * std::abs(start));
    for (double t = pair_.t_max() * 0x1p-40;; t *= 2.0) {
      t = std::min(t, pair_.t_max());
      const double now = query(t);
      if (now > touching()) {
        t_ = t;
        return true;
      }
      if (now < start - noise && now < -touching()) {
        result_.time = 0.0;
        return false;
      }
      if (t >= pair_.t_max()) return false;
    }
  }

  // One certified step from t_.
  void advance() {
    const double gap = query(t_);
    // A step to a predicted root that no longer shrinks the gap: what is left is noise of the
    // distance.
    const double rounding = pair_.rounding(t_);
    const bool stalled = approaching_ && gap > 0.5 * last_gap_ && gap <= 1e-8 * pair_.size();
    if (gap <= rounding || (stalled && gap <= 32.0 * rounding)) {
      result_.time = t_;
      return;
    }
    if (stalled) {
      approaching_ = false;
      close_in(gap);
      return;
    }
    last_gap_ = gap;
    approaching_ = false;
    const Vec3 n = nearest_.normal;
    const double f0 = pair_.gap_along(n, t_);
    // Almost touching, a normal made of two nearest points is noise: work on the distance itself.
    if (!(f0 >= 0.5 * gap)) {
      close_in(gap);
      return;
    }
    const double left = pair_.t_max() - t_;
    const double slow = f0 / std::max(pair_.speed(t_), 1e-300);  // nothing moves faster than this
    if (slow >= left) {
      t_ = pair_.t_max();
      return;
    }
    double h = std::min(left, std::max(trial_, slow));
    for (;;) {
      const double step =
          std::max(slow, certified_step(f0, pair_.gap_along(n, t_ + h), h, pair_.curvature()));
      if (step >= h) {
        t_ = h == left ? pair_.t_max() : t_ + h;
        trial_ = 4.0 * h;
        return;
      }
      // A shorter trial makes a better chord; worth it until the step takes most of it.
      if (step >= 0.25 * h || h <= slow) {
        const double taken = std::max(step, followed_step(std::min(gap, f0), n, step));
        if (t_ + taken == t_) result_.time = t_;
        t_ += taken;
        approaching_ = true;
        trial_ = 4.0 * step;
        return;
      }
      h = std::max({2.0 * step, 0.125 * h, slow});
    }
  }

  // Edges that turn against each other lose along a fixed axis what their normal, turning with
  // them, keeps. The same step for an axis that turns from n to the normal a little later; 0 where
  // `fixed`, the step along the fixed axis, is not short of what curvature allows.
  double followed_step(double gap, const Vec3& n, double fixed) {
    if (pair_.has_plane()) return 0.0;
    const double expected = pair_.curvature(pair_.angular_speed(), t_);
    const double h = std::min(pair_.t_max() - t_, std::sqrt(8.0 * gap / expected));
    if (!(fixed < 0.2 * h)) return 0.0;
    query(t_ + h);
    const double chord = (nearest_.normal - n).norm();
    if (!(chord < 0.7)) return 0.0;
    constexpr double arc = 1.03;  // an arc is at most so much longer than such a chord
    const double curvature = pair_.curvature(arc * chord / h, t_);
    return certified_step(gap, pair_.gap_along(nearest_.normal, t_ + h), h, curvature);
  }

  // From a gap too small for normals: find the sign change of the distance, or the way out of the
  // gap.
  void close_in(double gap) {
    const double near = std::max(2.0 * gap, 1e-7 * pair_.size());
    const double longest = std::sqrt(8.0 * near / std::max(pair_.curvature(), 1e-300));
    double before = t_, before_gap = gap;
    double h = gap / std::max(pair_.speed(t_), 1e-300);
    while (before < pair_.t_max() && result_.iterations < most_queries_) {
      const double t = std::min(before + h, pair_.t_max());
      if (!(t > before)) {  // time itself can't tell the gap from zero
        result_.time = t;
        return;
      }
      const double now = query(t);
      if (std::abs(now) <= pair_.rounding(t)) {
        result_.time = t;
        return;
      }
      if (now < 0.0) {
        result_.time = bracketed_root(pair_, before, before_gap, t, now, result_.iterations);
        return;
      }
      t_ = before = t;
      before_gap = now;
      if (now > near) return;
      h = std::min(2.0 * h, longest);
    }
    t_ = before;
  }

  const ConvexPair& pair_;
  int most_queries_;
  ImpactSearch result_;
  DistanceResult nearest_;
  double t_ = 0.0;
  double trial_ = std::numeric_limits<double>::infinity();
  double last_gap_ = 0.0;
  bool approaching_ = false;  // the last step went to the root of the lower bound
};

void keep_earlier(ImpactSearch& best, const ImpactSearch& other) {
  best.iterations += other.iterations;
  if (!other.time || (best.time && *best.time <= *other.time)) return;
  best.time = other.time;
  best.converged = other.converged;
}

}  // namespace

ImpactSearch find_time_of_impact(const Shape& a, const Sweep& motion_a, const Shape& b,
                                 const Sweep& motion_b, double t_max, int most_queries) {
  if (!(t_max >= 0.0) || !std::isfinite(t_max)) {
    throw std::invalid_argument("time_of_impact: t_max must be finite and >= 0");
  }
  if (const auto* compound = std::get_if<Compound>(&a)) {
    ImpactSearch best;
    for (const CompoundPart& part : compound->data->parts) {
      const PartSweep motion(motion_a, part.pose);
      keep_earlier(best, find_time_of_impact(part.shape, motion, b, motion_b,
                                             best.time.value_or(t_max), most_queries));
    }
    return best;
  }
  if (std::holds_alternative<Compound>(b)) {
    return find_time_of_impact(b, motion_b, a, motion_a, t_max, most_queries);
  }
  if (is_surface(b)) return surface_time_of_impact(a, motion_a, b, motion_b, t_max, most_queries);
  if (is_surface(a)) return surface_time_of_impact(b, motion_b, a, motion_a, t_max, most_queries);
  const ConvexPair pair(a, motion_a, b, motion_b, t_max);
  return Search(pair, most_queries).run();
}

}  // namespace rb
