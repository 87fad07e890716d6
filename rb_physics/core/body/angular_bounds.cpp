#include "body/angular_bounds.hpp"

#include <cmath>

namespace rb {
namespace {

constexpr double inv_sqrt_3 = 0.57735026918962585;  // above 1 / sqrt 3

}  // namespace

double max_angular_speed(const RigidState& state, const Inertia& inertia, double torque, double t) {
  if (inertia.isotropic) return inertia.inv_body(0, 0) * (state.L.norm() + t * torque);
  const Vec3 omega = angular_velocity(state, inertia);
  const double inverse = inertia.inv_body.trace();
  const double energy =
      std::sqrt(inverse * std::fmax(0.0, omega.dot(state.L))) + t * inverse * torque;
  const double start = omega.norm();
  const double guess = 2.0 * (start + t * inverse * torque);
  const double grown = start + t * (guess * guess * inv_sqrt_3 + inverse * torque);
  // If the speed stays below the guess, it grows no faster than this.
  return grown <= guess ? std::fmin(grown, energy) : energy;
}

double max_angular_acceleration(const Inertia& inertia, double torque, double speed) {
  if (inertia.isotropic) return inertia.inv_body(0, 0) * torque;
  return speed * speed * inv_sqrt_3 + inertia.inv_body.trace() * torque;
}

}  // namespace rb
