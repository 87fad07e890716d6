#include "world/free_sweep.hpp"

#include <algorithm>
#include <cmath>

#include "body/angular_bounds.hpp"
#include "body/free_motion.hpp"
#include "world/kinematic.hpp"

namespace rb {

FreeSweep::FreeSweep(const Body& body, const RigidState& start, const Wrench& wrench, double t_max)
    : body_(body), start_(start), wrench_(wrench) {
  if (!body.is_dynamic()) {
    velocity_ = body.velocity;
    angular_speed_ = body.spin.norm();
    return;
  }
  const Inertia& in = body.inertia;
  velocity_ = linear_velocity(start, in);
  acceleration_ = in.inv_mass * wrench.force;
  angular_speed_ = rb::max_angular_speed(start, in, wrench.torque.norm(), t_max);
  constexpr double many = 8.0;  // rad
  const double angle = angular_speed_ * t_max;
  if (wrench.torque.isZero(0.0) && !in.isotropic && angle > many) {
    const auto most = static_cast<double>(knots_.size() - 1);
    knot_time_ = t_max / std::fmin(most, std::ceil(0.5 * angle));
    knots_[0] = start.q;
    known_knots_ = 1;
  }
  angular_acceleration_ = rb::max_angular_acceleration(in, wrench.torque.norm(), angular_speed_);
}

Pose FreeSweep::at(double t) const {
  if (!body_.is_dynamic()) return kinematic_pose(body_, t);
  if (knot_time_ > 0.0) {
    const Quat q = orientation(t);
    return {center(t) - q * body_.center_of_mass, q};
  }
  const RigidState s = move_free(start_, body_.inertia, wrench_, t);
  return {s.x - s.q * body_.center_of_mass, s.q};
}

Quat FreeSweep::orientation(double t) const {
  const int last = static_cast<int>(knots_.size()) - 1;
  const int k = std::clamp(static_cast<int>(t / knot_time_), 0, last);
  for (; known_knots_ <= k; ++known_knots_) {
    knots_[known_knots_] =
        rotate_free(knots_[known_knots_ - 1], start_.L, body_.inertia, knot_time_);
  }
  return rotate_free(knots_[k], start_.L, body_.inertia, t - k * knot_time_);
}

Vec3 FreeSweep::center(double t) const {
  return (body_.is_dynamic() ? start_.x : body_.state.x) +
         t * (velocity_ + (0.5 * t) * acceleration_);
}

}  // namespace rb
