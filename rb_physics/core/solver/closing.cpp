#include "solver/closing.hpp"

#include <algorithm>
#include <limits>

#include "solver/contact_operators.hpp"

namespace rb {

bool close_contacts(const ContactProblem& problem, const std::vector<std::uint8_t>& closed,
                    double max_work, BodySpace& space, ClosingWorkspace& ws,
                    std::vector<Vec6>& displacement) {
  constexpr double softness = 1e-8;  // relative: it keeps redundant contacts regular
  constexpr int passes = 2;          // each leaves about that much of the gaps
  const std::size_t nb = problem.inv_mass.size(), nc = problem.contacts.size();
  displacement.assign(nb, Vec6::Zero());
  if (!space.prepare(problem, max_work)) return false;
  ws.cones.assign(nc, FrictionCone{});
  ws.d.resize(nc);
  double least = std::numeric_limits<double>::infinity();  // 1/kg
  for (std::size_t i = 0; i < nc; ++i) {
    ws.d[i].ff.setZero();
    if (!closed[i]) continue;
    ws.d[i].ff(0, 0) = 1.0;
    least = std::min(least, inverse_effective_mass(problem, problem.contacts[i]));
  }
  const double weight = 1.0 / (softness * least);
  if (!space.factorize(problem, ws.cones, ws.d, weight, true)) return false;
  for (int pass = 0; pass < passes; ++pass) {
    ws.wrench.assign(nb, Vec6::Zero());
    for (std::size_t i = 0; i < nc; ++i) {
      if (!closed[i]) continue;
      const ContactConstraint& c = problem.contacts[i];
      const double gap = relative_velocity(c, displacement).x();
      add_wrench(c, ws.cones[i], {Vec3(-weight * gap, 0.0, 0.0), Vec3::Zero()}, ws.wrench);
    }
    space.scale_transposed(ws.wrench, ws.z);
    space.solve(ws.z);
    space.scale(ws.z, ws.step);
    for (std::size_t k = 0; k < nb; ++k) displacement[k] += ws.step[k];
  }
  return true;
}

}  // namespace rb
