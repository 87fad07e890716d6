// Motions given in closed form, for time_of_impact.
#pragma once

#include <cmath>

#include "collision/queries.hpp"
#include "math/types.hpp"

namespace rb {

// The centre follows a parabola c + v t + a t^2 / 2, the body turns about it at a constant world
// angular velocity: q(t) = exp(omega t / 2) q. A body at rest is the special case of zeros.
class BallisticSweep final : public Sweep {
 public:
  // `pose` of the body frame at t = 0; `center` in body coordinates, m; velocity (m/s),
  // acceleration (m/s^2) and angular velocity (rad/s) in world axes; t_max in s, the interval the
  // bounds hold on. Throws std::invalid_argument for values that are not finite.
  BallisticSweep(const Pose& pose, const Vec3& center, const Vec3& velocity,
                 const Vec3& acceleration, const Vec3& angular_velocity, double t_max);

  static BallisticSweep fixed(const Pose& pose) {
    return {pose, Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), 0.0};
  }

  Pose at(double t) const override;
  Vec3 center(double t) const override;
  Vec3 velocity(double t) const override { return velocity_ + t * acceleration_; }
  Vec3 acceleration() const override { return acceleration_; }
  double max_angular_speed() const override { return angular_speed_; }
  double max_angular_acceleration() const override { return 0.0; }

 private:
  Quat orientation_;       // at t = 0
  Vec3 local_center_;      // m, body coordinates
  Vec3 center_;            // m, world, at t = 0
  Vec3 velocity_;          // m/s, at t = 0
  Vec3 acceleration_;      // m/s^2
  Vec3 angular_velocity_;  // rad/s
  double angular_speed_;   // rad/s
};

// Another sweep seen from a part that is fixed to the moving body: part pose = body pose * local.
class PartSweep final : public Sweep {
 public:
  PartSweep(const Sweep& body, const Pose& local) : body_(body), local_(local) {}

  Pose at(double t) const override { return body_.at(t) * local_; }
  Vec3 center(double t) const override { return body_.center(t); }
  Vec3 velocity(double t) const override { return body_.velocity(t); }
  Vec3 acceleration() const override { return body_.acceleration(); }
  double max_angular_speed() const override { return body_.max_angular_speed(); }
  double max_angular_acceleration() const override { return body_.max_angular_acceleration(); }

 private:
  const Sweep& body_;
  Pose local_;
};

// m/s: the greatest speed of the two centres relative to each other on [t, t_max]. Along a parabola
// it is a convex function of time: the ends bound it.
inline double max_relative_speed(const Sweep& a, const Sweep& b, double t, double t_max) {
  return std::fmax((a.velocity(t) - b.velocity(t)).norm(),
                   (a.velocity(t_max) - b.velocity(t_max)).norm());
}

// The rest of another sweep: time 0 here is time `start` there.
class LaterSweep final : public Sweep {
 public:
  LaterSweep(const Sweep& whole, double start) : whole_(whole), start_(start) {}

  Pose at(double t) const override { return whole_.at(start_ + t); }
  Vec3 center(double t) const override { return whole_.center(start_ + t); }
  Vec3 velocity(double t) const override { return whole_.velocity(start_ + t); }
  Vec3 acceleration() const override { return whole_.acceleration(); }
  double max_angular_speed() const override { return whole_.max_angular_speed(); }
  double max_angular_acceleration() const override { return whole_.max_angular_acceleration(); }

 private:
  const Sweep& whole_;
  double start_;  // s
};

}  // namespace rb
