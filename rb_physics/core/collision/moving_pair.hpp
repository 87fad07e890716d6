// Two convex shapes in motion: their geometry at a time, and bounds on how soon they can meet.
//
// For a fixed world axis n the gap f(t) = min n.x over A - max n.x over B is a lower bound of the
// distance, with equality at the time where n is the shapes' normal. The height difference of every
// pair of points along n has a second derivative of at most C = n.a + sum of (omega^2 + alpha) R, a
// the relative acceleration of the centres, about which the bodies turn, R their radius. So it lies
// at most C s (h - s) / 2 below its chord over [0, h], and so does the least of them:
//   f(t + s) >= f(t) + (f(t + h) - f(t)) s / h - C s (h - s) / 2.
// Up to the first root of the right side nothing can touch. Near an impact h shrinks with the gap,
// the chord becomes the tangent, and the steps converge from below like Newton's; past a graze of
// depth delta they number about log(1 / delta). (Conservative advancement, Mirtich 1996, uses the
// first derivative only and crawls in both cases.)
#pragma once

#include <optional>

#include "collision/queries.hpp"
#include "math/types.hpp"
#include "shape/shape.hpp"

namespace rb {

class MovingPair {
 public:
  // Refers to the shapes and the sweeps. Not for two half-spaces (std::invalid_argument), compounds
  // or surfaces of triangles. t_max in s.
  MovingPair(const Shape& a, const Sweep& motion_a, const Shape& b, const Sweep& motion_b,
             double t_max);

  double t_max() const { return t_max_; }
  // s, at most t_max: beyond it positions or attitudes are lost in rounding.
  double horizon() const { return horizon_; }
  double size() const { return size_; }  // m, radius of the smaller shape
  bool has_plane() const { return plane_ != Plane::NONE; }
  double angular_speed() const { return angular_speed_; }  // rad/s, bound of the sum of both
  double rounding(double t) const;                         // m, below it a gap is rounding
  double effort(double t) const;                           // of a distance at t, microseconds

  DistanceResult distance_at(double t) const;  // points relative to B's centre
  double gap(double t) const { return distance_at(t).distance; }
  // f(t) along the axis n; for a half-space along its own normal, which is the true distance.
  double gap_along(const Vec3& n, double t) const;

  // m/s^2, C for the axis n, and for any axis that stays.
  double curvature(const Vec3& n) const;
  double max_curvature() const { return acceleration_.norm() + turning_curvature_; }
  // The same for an axis that turns at `rate` (rad/s) over [t, t + h].
  double curvature(double rate, double t, double h) const;
  // s: over a longer chord the turning alone may cost the lower bound more than the shapes' size.
  double useful_chord() const;
  // s: the shapes near each other by less than `gap` (m) within that time from t on.
  double time_to_cover(double gap, double t) const;
  // Until when the balls about the centres that hold the shapes, however they turn, stay apart: t
  // or later, at most t_max.
  double apart_until(double t) const;

  // Which of the shapes a ball should stand for, and its radius (m), where it turns so fast that a
  // ball is all one can follow; nothing where neither does.
  struct Ball {
    bool of_a;
    double radius;
  };
  std::optional<Ball> ball() const;
  const Shape& shape(bool of_a) const { return of_a ? a_ : b_; }
  const Sweep& motion(bool of_a) const { return of_a ? motion_a_ : motion_b_; }

 private:
  enum class Plane { NONE, A, B };

  Vec3 apart(double t) const { return start_ + t * (velocity_ + (0.5 * t) * acceleration_); }
  Vec3 velocity(double t) const { return velocity_ + t * acceleration_; }
  double speed(double t, double h) const;  // m/s, bound over [t, t + h] of any two points
  Pose pose_a(double t) const;
  Pose pose_b(double t) const;

  const Shape& a_;
  const Shape& b_;
  const Sweep& motion_a_;
  const Sweep& motion_b_;
  double t_max_, horizon_;
  Plane plane_ = Plane::NONE;
  Vec3 middle_a_ = Vec3::Zero();  // m, world, from the sweep's centre to the one used here
  Vec3 middle_b_ = Vec3::Zero();
  Vec3 start_;                                // m, from B's centre to A's at 0
  Vec3 velocity_;                             // m/s, of A's centre seen from B's at 0
  Vec3 acceleration_;                         // m/s^2
  double radius_a_ = 0.0, radius_b_ = 0.0;    // m, hold the shapes; 0 for a half-space
  double turning_a_ = 0.0, turning_b_ = 0.0;  // m/s, of surface points about the centre
  double plane_reach_ = 0.0;                  // m, of the plane from its body
  double size_, scale_, turning_speed_, angular_speed_, arms_;
  double turning_curvature_;  // m/s^2
};

// First root in (0, h) of f0 + (f1 - f0) s / h - C s (h - s) / 2, or h when it stays positive;
// f0 > 0.
double certified_step(double f0, double f1, double h, double curvature);

}  // namespace rb
