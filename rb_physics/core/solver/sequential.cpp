#include "solver/contact_operators.hpp"
#include "solver/normal_delassus.hpp"
#include "solver/normal_impact.hpp"

namespace rb {
namespace {

// Collisions per contact before the inelastic answer ends the sequence: jammed contacts with
// restitution pass impulses to and fro for ever.
constexpr int kMaxRounds = 1000;

}  // namespace

NormalImpact sequential_impact(const ContactProblem& problem, SolverWorkspace& workspace) {
  NormalImpact out;
  const Eigen::Index nc = static_cast<Eigen::Index>(problem.contacts.size());
  out.impulse = Eigen::VectorXd::Zero(nc);
  out.velocity = problem.velocity;
  const double tiny = approach_threshold(normal_speeds(problem, problem.velocity));
  std::vector<double> a(nc);
  for (Eigen::Index i = 0; i < nc; ++i) {  // A_ii: speed that a unit impulse gives its own contact
    ContactConstraint c = problem.contacts[i];
    c.bias.setZero();
    std::vector<Vec6> v(problem.inv_mass.size(), Vec6::Zero());
    apply_impulse(problem, c, Vec3(1.0, 0.0, 0.0), v);
    a[i] = relative_velocity(c, v)[0];
  }
  for (int round = 0; round < kMaxRounds; ++round) {
    bool approaching = false;
    for (Eigen::Index i = 0; i < nc; ++i) {
      const ContactConstraint& c = problem.contacts[i];
      const double d_dot = relative_velocity(c, out.velocity)[0];
      if (!(d_dot < -tiny)) continue;
      approaching = true;
      const double f = single_contact_impulse(d_dot, a[i], c.restitution);
      out.impulse[i] += f;
      apply_impulse(problem, c, Vec3(f, 0.0, 0.0), out.velocity);
      ++out.iterations;
    }
    if (!approaching) return out;
  }
  out.capped = true;
  const NormalImpact rest = inelastic_projection(problem, out.velocity, {}, workspace);
  out.impulse += rest.impulse;
  out.velocity = rest.velocity;
  return out;
}

}  // namespace rb
