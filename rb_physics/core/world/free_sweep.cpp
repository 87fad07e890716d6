#include "world/free_sweep.hpp"

#include <cmath>

#include "body/angular_bounds.hpp"
#include "body/free_motion.hpp"
#include "collision/sweep.hpp"
#include "world/kinematic.hpp"

namespace rb {

namespace {

constexpr double turn_per_stride = 4.0;        // rad
constexpr double most_turn_in_pieces = 1e5;    // rad: a tenth of a second of work
constexpr double turn_per_microsecond = 0.25;  // rad of free rotation worked out

}  // namespace

FreeSweep::FreeSweep(const Body& body, const RigidState& start, const Wrench& wrench, double t_max)
    : body_(body), start_(start), wrench_(wrench), t_max_(t_max) {
  if (!body.is_dynamic()) {
    velocity_ = body.velocity;
    angular_speed_ = body.spin.norm();
    return;
  }
  const Inertia& in = body.inertia;
  velocity_ = rb::linear_velocity(start, in);
  acceleration_ = in.inv_mass * wrench.force;
  angular_speed_ = rb::max_angular_speed(start, in, wrench.torque.norm(), t_max);
  angular_acceleration_ = rb::max_angular_acceleration(in, wrench.torque.norm(), angular_speed_);
  if (!in.isotropic && angular_speed_ > 0.0 && wrench.torque.isZero(0.0)) {
    stride_ = turn_per_stride / angular_speed_;
  }
}

Quat FreeSweep::orientation(double t) const {
  if (stride_ == 0.0 || t <= stride_) return move_free(start_, body_.inertia, wrench_, t).q;
  // Without torque the angular momentum stays: from the attitude at the last whole stride on.
  const auto strides = static_cast<std::size_t>(t / stride_);
  if (on_the_way_.empty()) on_the_way_.push_back(start_.q);
  while (on_the_way_.size() <= strides) {
    on_the_way_.push_back(rotate_free(on_the_way_.back(), start_.L, body_.inertia, stride_));
  }
  const double rest = t - static_cast<double>(strides) * stride_;
  return rotate_free(on_the_way_[strides], start_.L, body_.inertia, rest);
}

Pose FreeSweep::about_center(double t) const {
  if (!body_.is_dynamic()) {
    const Pose pose = kinematic_pose(body_, t);
    return {-(pose.orientation * body_.center_of_mass), pose.orientation};
  }
  const Quat q = orientation(t);
  return {-(q * body_.center_of_mass), q};
}

Vec3 FreeSweep::center(double t) const {
  return (body_.is_dynamic() ? start_.x : body_.state.x) +
         t * (velocity_ + (0.5 * t) * acceleration_);
}

Sweep::AxisTurn FreeSweep::axis_turn(const Vec3& axis) const {
  if (!body_.is_dynamic()) {
    const double speed = body_.spin.cross(axis).norm();
    return {speed, speed * angular_speed_};
  }
  const AxisTurn any{angular_speed_, angular_acceleration_ + angular_speed_ * angular_speed_};
  const Vec3 u = start_.q.conjugate() * axis;
  const Mat3& inverse = body_.inertia.inv_body;
  const double across = 0.5 * (inverse.trace() - u.dot(inverse * u));
  // A symmetric top: without torque its axis goes round the angular momentum at the rate L / J,
  // J across the axis. How far it is not one counts as a tilt that grows while it turns.
  const Mat3 top = across * Mat3::Identity() + (u.dot(inverse * u) - across) * u * u.transpose();
  const double odd = (inverse - top).norm() / across;
  if (!wrench_.torque.isZero(0.0) || !(odd < 1e-9)) return any;
  const double momentum = start_.L.norm();
  if (momentum == 0.0) return {0.0, 0.0};
  const double rate = across * momentum;
  const double tilt =
      start_.L.cross(axis).norm() / momentum + 1e-15 + 4.0 * odd * angular_speed_ * t_max_;
  return {std::fmin(any.speed, rate * tilt), std::fmin(any.acceleration, rate * rate * tilt)};
}

double FreeSweep::resolved_until() const {
  const bool in_pieces = body_.is_dynamic() && !body_.inertia.isotropic;
  return (in_pieces ? most_turn_in_pieces : most_turn) / angular_speed_;
}

double FreeSweep::effort(double t) const {
  if (!body_.is_dynamic() || body_.inertia.isotropic || stride_ > 0.0) return 0.0;
  return angular_speed_ * t / turn_per_microsecond;
}

}  // namespace rb
