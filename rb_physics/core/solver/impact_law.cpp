#include "solver/impact_law.hpp"

#include "solver/contact_operators.hpp"

namespace rb {

ImpactReport apply_impact(const ContactProblem& problem, ImpactLaw, ContactSolution& out,
                          SolverWorkspace& workspace) {
  // Newton's law for all contacts at once: u_n+ >= -epsilon u_n-, Coulomb's cone.
  ContactProblem with_rebound = problem;
  for (ContactConstraint& c : with_rebound.contacts) {
    const double u = relative_velocity(c, problem.velocity).x();
    if (u < 0.0) c.bias.x() += c.restitution * u;
  }
  out.impulse.clear();
  out.moment.clear();
  out.certificate.clear();
  const SolveReport report = solve_contacts(with_rebound, SolverSettings{}, out, workspace);
  return {report.residual, 0.0, report.sweeps + report.newton_steps};
}

}  // namespace rb
