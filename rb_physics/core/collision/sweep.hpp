// Motions given in closed form, for time_of_impact.
#pragma once

#include <limits>

#include "collision/queries.hpp"
#include "math/types.hpp"

namespace rb {

constexpr double most_turn = 1e9;  // rad, an angle beyond it has lost half its digits

// The centre follows a parabola c + v t + a t^2 / 2, the body turns about it at a constant world
// angular velocity: q(t) = exp(omega t / 2) q. A body at rest is the special case of zeros.
class BallisticSweep final : public Sweep {
 public:
  // `pose` of the body frame at t = 0; `center` in body coordinates, m; velocity (m/s),
  // acceleration (m/s^2) and angular velocity (rad/s) in world axes. Throws std::invalid_argument
  // for values that are not finite.
  BallisticSweep(const Pose& pose, const Vec3& center, const Vec3& velocity,
                 const Vec3& acceleration, const Vec3& angular_velocity);

  Vec3 center(double t) const override;
  Vec3 linear_velocity() const override { return velocity_; }
  Vec3 linear_acceleration() const override { return acceleration_; }
  Pose about_center(double t) const override;
  double max_angular_speed() const override { return angular_speed_; }
  double max_angular_acceleration() const override { return 0.0; }
  AxisTurn axis_turn(const Vec3& axis) const override {
    const double speed = angular_velocity_.cross(axis).norm();
    return {speed, speed * angular_speed_};
  }
  double resolved_until() const override { return most_turn / angular_speed_; }
  double effort(double) const override { return 0.0; }

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

  Vec3 center(double t) const override { return body_.center(t); }
  Vec3 linear_velocity() const override { return body_.linear_velocity(); }
  Vec3 linear_acceleration() const override { return body_.linear_acceleration(); }
  Pose about_center(double t) const override { return body_.about_center(t) * local_; }
  double max_angular_speed() const override { return body_.max_angular_speed(); }
  double max_angular_acceleration() const override { return body_.max_angular_acceleration(); }
  AxisTurn axis_turn(const Vec3& axis) const override { return body_.axis_turn(axis); }
  double resolved_until() const override { return body_.resolved_until(); }
  double effort(double t) const override { return body_.effort(t); }

 private:
  const Sweep& body_;
  Pose local_;
};

// The flight of another sweep's centre alone, without the rotation.
class CenterSweep final : public Sweep {
 public:
  explicit CenterSweep(const Sweep& body) : body_(body) {}

  Vec3 center(double t) const override { return body_.center(t); }
  Vec3 linear_velocity() const override { return body_.linear_velocity(); }
  Vec3 linear_acceleration() const override { return body_.linear_acceleration(); }
  Pose about_center(double) const override { return {Vec3::Zero(), Quat::Identity()}; }
  double max_angular_speed() const override { return 0.0; }
  double max_angular_acceleration() const override { return 0.0; }
  AxisTurn axis_turn(const Vec3&) const override { return {0.0, 0.0}; }
  double resolved_until() const override { return std::numeric_limits<double>::infinity(); }
  double effort(double) const override { return 0.0; }

 private:
  const Sweep& body_;
};

}  // namespace rb
