// The motion a body will make when nothing new meets it, as a curve of poses for time_of_impact.
#pragma once

#include <vector>

#include "body/body.hpp"
#include "collision/queries.hpp"

namespace rb {

// A dynamic body under a constant wrench, from `start` on, as move_free has it; or a kinematic body
// at constant velocity and spin; or a static one. `t_max` in s: the interval the bounds hold on.
// For one thread: free rotation is worked out piece by piece, and what was passed is kept.
class FreeSweep final : public Sweep {
 public:
  FreeSweep(const Body& body, const RigidState& start, const Wrench& wrench, double t_max);

  Vec3 center(double t) const override;
  Vec3 linear_velocity() const override { return velocity_; }
  Vec3 linear_acceleration() const override { return acceleration_; }
  Pose about_center(double t) const override;
  double max_angular_speed() const override { return angular_speed_; }
  double max_angular_acceleration() const override { return angular_acceleration_; }
  AxisTurn axis_turn(const Vec3& axis) const override;
  double resolved_until() const override;
  double effort(double t) const override;

 private:
  Quat orientation(double t) const;

  const Body& body_;
  RigidState start_;
  Wrench wrench_;
  Vec3 velocity_;                         // m/s, at t = 0
  Vec3 acceleration_ = Vec3::Zero();      // m/s^2
  double t_max_;                          // s
  double angular_speed_ = 0.0;            // rad/s
  double angular_acceleration_ = 0.0;     // rad/s^2
  double stride_ = 0.0;                   // s between two of `on_the_way_`; 0: none are kept
  mutable std::vector<Quat> on_the_way_;  // attitudes at whole numbers of strides, as asked for
};

}  // namespace rb
