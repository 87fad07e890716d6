#include "collision/sweep.hpp"

#include <cmath>
#include <stdexcept>

#include "math/rotation.hpp"

namespace rb {

BallisticSweep::BallisticSweep(const Pose& pose, const Vec3& center, const Vec3& velocity,
                               const Vec3& acceleration, const Vec3& angular_velocity)
    : orientation_(pose.orientation),
      local_center_(center),
      center_(pose.apply(center)),
      velocity_(velocity),
      acceleration_(acceleration),
      angular_velocity_(angular_velocity),
      angular_speed_(angular_velocity.norm()) {
  if (!center_.allFinite() || !velocity.allFinite() || !acceleration.allFinite() ||
      !std::isfinite(angular_speed_)) {
    throw std::invalid_argument("sweep: pose, velocities and acceleration must be finite");
  }
}

Vec3 BallisticSweep::center(double t) const {
  return center_ + t * (velocity_ + 0.5 * t * acceleration_);
}

Pose BallisticSweep::about_center(double t) const {
  if (angular_speed_ == 0.0) return {-(orientation_ * local_center_), orientation_};
  const Quat q = quaternion_from_rotation_vector(t * angular_velocity_) * orientation_;
  return {-(q * local_center_), q};
}

}  // namespace rb
