// The motion a body will make when nothing new meets it, as a curve of poses for time_of_impact.
#pragma once

#include <array>

#include "body/body.hpp"
#include "collision/queries.hpp"

namespace rb {

// A dynamic body under a constant wrench, from `start` on, as move_free has it; or a kinematic body
// at constant velocity and spin; or a static one. `t_max` in s: the interval the bounds hold on.
class FreeSweep final : public Sweep {
 public:
  FreeSweep(const Body& body, const RigidState& start, const Wrench& wrench, double t_max);

  Pose at(double t) const override;
  Vec3 center(double t) const override;
  Vec3 velocity(double t) const override { return velocity_ + t * acceleration_; }
  Vec3 acceleration() const override { return acceleration_; }
  double max_angular_speed() const override { return angular_speed_; }
  double max_angular_acceleration() const override { return angular_acceleration_; }

 private:
  Quat orientation(double t) const;

  const Body& body_;
  RigidState start_;
  Wrench wrench_;
  Vec3 velocity_;                      // m/s, at t = 0
  Vec3 acceleration_ = Vec3::Zero();   // m/s^2
  double angular_speed_ = 0.0;         // rad/s
  double angular_acceleration_ = 0.0;  // rad/s^2
  // Of a body that turns many times: orientations at multiples of `knot_time_`, from which the
  // others are reached; worked out as far as they were asked for.
  double knot_time_ = 0.0;  // s; 0: none
  mutable std::array<Quat, 257> knots_;
  mutable int known_knots_ = 0;
};

}  // namespace rb
