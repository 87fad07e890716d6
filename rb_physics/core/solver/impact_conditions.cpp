#include "solver/impact_conditions.hpp"

#include <algorithm>
#include <cmath>

#include "solver/contact_operators.hpp"

namespace rb {

double ImpactConditions::worst() const {
  return std::max({attraction, penetration, energy_gain, cone});
}

ImpactConditions impact_conditions(const ContactProblem& problem, const std::vector<Vec3>& impulse,
                                   const std::vector<Vec3>& moment,
                                   const std::vector<Vec6>& after) {
  ImpactConditions r;
  double largest_impulse = 0.0, largest_slip = 0.0, energy = 0.0, turned = 0.0;
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const ContactConstraint& c = problem.contacts[i];
    const Vec3 before_u = relative_velocity(c, problem.velocity);
    const Vec3 after_u = relative_velocity(c, after);
    largest_impulse = std::max(largest_impulse, impulse[i].norm());
    largest_slip = std::max(largest_slip, before_u.norm());
    r.attraction = std::max(r.attraction, -impulse[i][0]);
    r.penetration = std::max(r.penetration, -after_u[0]);
    const double bound = std::max(c.friction, c.static_friction) * impulse[i][0];
    r.cone = std::max(r.cone, impulse[i].tail<2>().norm() - bound);
    // A f = u+ - u-, so that f . (A f + 2 d-) = f . (u+ + u-): twice the work of the impulses.
    energy += impulse[i].dot(after_u + before_u);
    turned += impulse[i].dot(after_u - before_u);
    if (moment.empty()) continue;
    const Vec3 before_w = relative_spin(c, problem.velocity);
    const Vec3 after_w = relative_spin(c, after);
    energy += moment[i].dot(after_w + before_w);
    turned += moment[i].dot(after_w - before_w);
  }
  if (largest_impulse > 0.0) {
    r.attraction /= largest_impulse;
    r.cone = std::max(r.cone, 0.0) / largest_impulse;
  }
  if (largest_slip > 0.0) r.penetration /= largest_slip;
  r.energy_gain = energy > 0.0 && turned > 0.0 ? energy / turned : 0.0;
  return r;
}

}  // namespace rb
