#include "body/rk4.hpp"

#include "math/rotation.hpp"

namespace rb {
namespace {

// s + h ds, the quaternion left unnormalised between the stages.
RigidState moved(const RigidState& s, const StateDerivative& d, double h) {
  RigidState out;
  out.x = s.x + h * d.x;
  out.q.coeffs() = s.q.coeffs() + h * d.q;
  out.p = s.p + h * d.p;
  out.L = s.L + h * d.L;
  return out;
}

}  // namespace

RigidState rk4_step(const RigidState& s, const Inertia& i, const Wrench& w, double h) {
  const StateDerivative k1 = derivative(s, i, w);
  const StateDerivative k2 = derivative(moved(s, k1, 0.5 * h), i, w);
  const StateDerivative k3 = derivative(moved(s, k2, 0.5 * h), i, w);
  const StateDerivative k4 = derivative(moved(s, k3, h), i, w);
  const double sixth = h / 6.0;
  RigidState out;
  out.x = s.x + sixth * (k1.x + 2.0 * k2.x + 2.0 * k3.x + k4.x);
  out.q.coeffs() = s.q.coeffs() + sixth * (k1.q + 2.0 * k2.q + 2.0 * k3.q + k4.q);
  out.q = normalized(out.q);
  out.p = s.p + h * w.force;
  out.L = s.L + h * w.torque;
  return out;
}

}  // namespace rb
