// The motion a body will make when nothing new meets it, as a curve of poses for time_of_impact.
#pragma once

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
  double max_angular_speed() const override { return angular_speed_; }
  double max_linear_speed(double t) const override;
  double max_angular_acceleration() const override { return angular_acceleration_; }
  double max_linear_acceleration() const override { return acceleration_.norm(); }

 private:
  const Body& body_;
  RigidState start_;
  Wrench wrench_;
  double t_max_;
  Vec3 velocity_;                      // m/s, at t = 0
  Vec3 acceleration_ = Vec3::Zero();   // m/s^2
  double angular_speed_ = 0.0;         // rad/s
  double angular_acceleration_ = 0.0;  // rad/s^2
};

}  // namespace rb
