#include "body/state.hpp"

#include <Eigen/LU>

#include "math/rotation.hpp"

namespace rb {

Mat3 inverse_of_inertia(const Mat3& inertia) {
  if (inertia == Mat3(inertia.diagonal().asDiagonal())) {
    return inertia.diagonal().cwiseInverse().asDiagonal();
  }
  const Mat3 inverse = inertia.inverse();
  return 0.5 * (inverse + inverse.transpose());
}

Mat3 world_inverse_inertia(const Quat& q, const Inertia& i) {
  if (i.isotropic) return i.inv_body;
  const Mat3 r = q.toRotationMatrix();
  const Mat3 m = r * i.inv_body * r.transpose();
  return 0.5 * (m + m.transpose());  // symmetric to the bit: solvers rely on it
}

Vec3 angular_velocity_in_turn(const RigidState& s, const Inertia& i) {
  return s.q * Vec3(i.inv_body * (s.q.conjugate() * s.L));
}

Vec3 angular_momentum(const Quat& q, const Inertia& i, const Vec3& omega) {
  if (i.isotropic) return i.body(0, 0) * omega;
  return q * Vec3(i.body * (q.conjugate() * omega));
}

StateDerivative derivative(const RigidState& s, const Inertia& i, const Wrench& w) {
  return {linear_velocity(s, i), quaternion_derivative(s.q, angular_velocity(s, i)), w.force,
          w.torque};
}

double kinetic_energy(const RigidState& s, const Inertia& i) {
  return 0.5 * i.inv_mass * s.p.squaredNorm() + 0.5 * s.L.dot(angular_velocity(s, i));
}

}  // namespace rb
