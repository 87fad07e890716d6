#include "solver/impact_law.hpp"

#include <algorithm>

#include "solver/contact_operators.hpp"
#include "solver/impact_friction.hpp"
#include "solver/normal_delassus.hpp"
#include "solver/normal_impact.hpp"

namespace rb {
namespace {

NormalImpact normal_impact(const ContactProblem& problem, ImpactLaw law, SolverWorkspace& ws) {
  if (problem.contacts.size() == 1) {
    NormalImpact out;
    const double a = normal_delassus(problem)(0, 0);
    const double d_dot = normal_speeds(problem, problem.velocity)[0];
    out.impulse.resize(1);
    out.impulse[0] = single_contact_impulse(d_dot, a, problem.contacts[0].restitution);
    out.velocity = problem.velocity;
    apply_normal_impulses(problem, out.impulse, out.velocity);
    out.iterations = 1;
    return out;
  }
  switch (law) {
    case ImpactLaw::SEQUENTIAL:
      return sequential_impact(problem, ws);
    case ImpactLaw::SIMULTANEOUS:
      return simultaneous_impact(problem, ws);
    case ImpactLaw::REFLECTIONS:
      break;
  }
  return reflections_impact(problem, ws);
}

}  // namespace

ImpactReport apply_impact(const ContactProblem& problem, ImpactLaw law, ContactSolution& out,
                          SolverWorkspace& workspace) {
  const std::size_t nc = problem.contacts.size();
  ImpactReport report;
  out.impulse.assign(nc, Vec3::Zero());
  out.moment.clear();
  out.certificate.clear();
  out.vain_searches = 0;
  out.velocity = problem.velocity;
  out.residual = 0.0;
  out.iterations = 0;
  out.converged = true;
  out.minimum_norm = false;
  const Eigen::VectorXd before = normal_speeds(problem, problem.velocity);
  if (nc == 0 || before.minCoeff() >= 0.0) return report;

  NormalImpact normal = normal_impact(problem, law, workspace);
  for (std::size_t i = 0; i < nc; ++i) {
    out.impulse[i][0] = normal.impulse[static_cast<Eigen::Index>(i)];
  }
  out.velocity = normal.velocity;
  report.iterations = normal.iterations;
  report.capped = normal.capped;
  report.iterations += impact_friction(problem, out.impulse, out.moment, out.velocity, workspace);
  velocity_from_impulses(problem, out.impulse, out.moment, out.velocity);
  report.conditions = impact_conditions(problem, out.impulse, out.moment, out.velocity);
  report.energy_gain = report.conditions.energy_gain;
  report.residual = report.conditions.worst();
  out.residual = report.residual;
  out.iterations = report.iterations;
  out.converged = report.residual <= tolerance::residual_ceiling;
  return report;
}

}  // namespace rb
