#include <limits>

#include "solver/normal_delassus.hpp"
#include "solver/normal_impact.hpp"

namespace rb {

double approach_threshold(const Eigen::VectorXd& d_dot) {
  double fastest = 0.0;
  for (const double d : d_dot) fastest = d < -fastest ? -d : fastest;
  return 1e-13 * fastest;
}

NormalImpact inelastic_projection(const ContactProblem& problem, const std::vector<Vec6>& v,
                                  const std::vector<char>& flagged, SolverWorkspace& workspace) {
  ContactProblem normal;
  normal.inv_mass = problem.inv_mass;
  normal.inv_inertia = problem.inv_inertia;
  normal.velocity = v;
  std::vector<Eigen::Index> index;
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    if (!flagged.empty() && !flagged[i]) continue;
    ContactConstraint c = problem.contacts[i];
    c.friction = c.static_friction = c.rolling_friction = c.spinning_friction = 0.0;
    normal.contacts.push_back(c);
    index.push_back(static_cast<Eigen::Index>(i));
  }
  ContactSolution solution;
  SolverSettings settings;
  settings.max_factor_work = 1e9;  // impacts are rare: exact at any size the chapter meets
  const SolveReport report = solve_contacts(normal, settings, solution, workspace);
  NormalImpact out;
  out.impulse = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem.contacts.size()));
  for (std::size_t k = 0; k < index.size(); ++k) out.impulse[index[k]] = solution.impulse[k][0];
  out.velocity = solution.velocity;
  out.iterations = report.sweeps + report.newton_steps;
  out.capped = !(report.residual <= 1e-9);
  return out;
}

}  // namespace rb
