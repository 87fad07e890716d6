#include "world/free_sweep.hpp"

#include <cmath>

#include "body/angular_bounds.hpp"
#include "body/free_motion.hpp"
#include "world/kinematic.hpp"

namespace rb {

FreeSweep::FreeSweep(const Body& body, const RigidState& start, const Wrench& wrench, double t_max)
    : body_(body), start_(start), wrench_(wrench), t_max_(t_max) {
  if (!body.is_dynamic()) {
    velocity_ = body.velocity;
    angular_speed_ = body.spin.norm();
    return;
  }
  const Inertia& in = body.inertia;
  velocity_ = linear_velocity(start, in);
  acceleration_ = in.inv_mass * wrench.force;
  angular_speed_ = rb::max_angular_speed(start, in, wrench.torque.norm(), t_max);
  angular_acceleration_ = rb::max_angular_acceleration(in, wrench.torque.norm(), angular_speed_);
}

Pose FreeSweep::at(double t) const {
  if (!body_.is_dynamic()) return kinematic_pose(body_, t);
  const RigidState s = move_free(start_, body_.inertia, wrench_, t);
  return {s.x - s.q * body_.center_of_mass, s.q};
}

Vec3 FreeSweep::center(double t) const {
  return (body_.is_dynamic() ? start_.x : body_.state.x) +
         t * (velocity_ + (0.5 * t) * acceleration_);
}

double FreeSweep::max_linear_speed(double t) const {
  // The speed of a parabola is convex in time: largest at an end.
  return std::fmax((velocity_ + t * acceleration_).norm(),
                   (velocity_ + t_max_ * acceleration_).norm());
}

}  // namespace rb
