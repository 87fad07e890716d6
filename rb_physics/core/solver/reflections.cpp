#include <algorithm>

#include "solver/normal_delassus.hpp"
#include "solver/normal_impact.hpp"

namespace rb {
namespace {

// f . (A f + 2 d_dot-) <= 0 with A f = d_dot+ - d_dot-.
bool gains_energy(const Eigen::VectorXd& f, const Eigen::VectorXd& before,
                  const Eigen::VectorXd& after) {
  return f.dot(after + before) > 1e-14 * std::abs(f.dot(after - before));
}

// (1 - epsilon_i) inelastic + epsilon_i elastic.
Eigen::VectorXd blend(const Eigen::VectorXd& inelastic, const Eigen::VectorXd& elastic,
                      const Eigen::VectorXd& epsilon) {
  return ((1.0 - epsilon.array()) * inelastic.array() + epsilon.array() * elastic.array()).matrix();
}

}  // namespace

NormalImpact reflections_impact(const ContactProblem& problem, SolverWorkspace& workspace) {
  const Eigen::Index nc = static_cast<Eigen::Index>(problem.contacts.size());
  NormalImpact elastic;
  elastic.impulse = Eigen::VectorXd::Zero(nc);
  elastic.velocity = problem.velocity;
  const Eigen::VectorXd before = normal_speeds(problem, problem.velocity);
  const double tiny = approach_threshold(before);
  const int max_passes = 100 + 20 * static_cast<int>(nc);  // ends finitely in practice
  std::vector<char> approaching(nc);
  for (;;) {
    const Eigen::VectorXd d_dot = normal_speeds(problem, elastic.velocity);
    bool any = false;
    for (Eigen::Index i = 0; i < nc; ++i) {
      approaching[i] = d_dot[i] < -tiny;
      any = any || approaching[i];
    }
    if (!any) break;
    elastic.capped = elastic.iterations >= max_passes;
    if (elastic.capped) approaching.assign(nc, 1);
    // Projection on the feasible cone; twice as far is the mirror image, of equal energy.
    const NormalImpact projection =
        inelastic_projection(problem, elastic.velocity, approaching, workspace);
    const double times = elastic.capped ? 1.0 : 2.0;
    elastic.impulse += times * projection.impulse;
    elastic.velocity = problem.velocity;
    apply_normal_impulses(problem, elastic.impulse, elastic.velocity);
    ++elastic.iterations;
    if (elastic.capped) break;
  }
  Eigen::VectorXd epsilon(nc);
  for (Eigen::Index i = 0; i < nc; ++i) epsilon[i] = problem.contacts[i].restitution;
  if (nc == 0 || epsilon.minCoeff() == 1.0) return elastic;

  const NormalImpact inelastic = inelastic_projection(problem, problem.velocity, {}, workspace);
  NormalImpact out = elastic;
  out.iterations += inelastic.iterations;
  const auto finish = [&](const Eigen::VectorXd& e) {
    out.impulse = blend(inelastic.impulse, elastic.impulse, e);
    out.velocity = problem.velocity;
    apply_normal_impulses(problem, out.impulse, out.velocity);
    return normal_speeds(problem, out.velocity);
  };
  // One coefficient for all blends two feasible answers: feasible. Different ones may not be: then
  // as near to them as is, from the least of those that are struck.
  const Eigen::VectorXd aim = finish(epsilon);
  const Eigen::VectorXd aimed = out.impulse;
  if (aim.minCoeff() >= -tiny && !gains_energy(aimed, before, aim)) return out;
  double least = 1.0;
  for (Eigen::Index i = 0; i < nc; ++i) {
    if (before[i] < -tiny) least = std::min(least, epsilon[i]);
  }
  const Eigen::VectorXd sure = finish(Eigen::VectorXd::Constant(nc, least));
  const Eigen::VectorXd surely = out.impulse;
  double low = 0.0, high = 1.0;  // share of what was aimed at; all of it is linear in the share
  for (int k = 0; k < 50; ++k) {
    const double share = 0.5 * (low + high);
    const Eigen::VectorXd after = sure + share * (aim - sure);
    const bool feasible = after.minCoeff() >= std::min(sure.minCoeff(), 0.0) &&
                          !gains_energy(surely + share * (aimed - surely), before, after);
    (feasible ? low : high) = share;
  }
  out.impulse = surely + low * (aimed - surely);
  out.velocity = problem.velocity;
  apply_normal_impulses(problem, out.impulse, out.velocity);
  return out;
}

}  // namespace rb
