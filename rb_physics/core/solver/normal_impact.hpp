// The normal part of the impact laws, without friction: from speeds before to impulses along N.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "contact/problem.hpp"
#include "solver/contact_solver.hpp"

namespace rb {

struct NormalImpact {
  Eigen::VectorXd impulse;     // f, N s, size nc
  std::vector<Vec6> velocity;  // after
  int iterations = 0;
  bool capped = false;
};

// S11, closed form: v+ = N_perp - epsilon (N . v-) N. Asserts S15's bounds on f.
// d_dot: speed before, m/s; a: A_ii, 1/kg. Throws std::logic_error if a bound is broken.
double single_contact_impulse(double d_dot, double a, double restitution);

// S12. Gauss-Seidel over collisions in index order: the result depends on that order.
NormalImpact sequential_impact(const ContactProblem& problem, SolverWorkspace& workspace);

// S13, S14.
NormalImpact simultaneous_impact(const ContactProblem& problem, SolverWorkspace& workspace);

// Smith et al. 2012: reflect about the feasible cone of the approaching contacts until none
// approaches; restitution < 1 blends with the inelastic answer.
NormalImpact reflections_impact(const ContactProblem& problem, SolverWorkspace& workspace);

// Plastic answer: least kinetic energy with f >= 0, d_dot+ >= 0 (the LCP with restitution 0) of the
// contacts flagged (all if empty), starting from v. Least-norm impulses.
NormalImpact inelastic_projection(const ContactProblem& problem, const std::vector<Vec6>& v,
                                  const std::vector<char>& flagged, SolverWorkspace& workspace);

// Speeds below it (m/s) count as not approaching: rounding of speeds of this problem.
double approach_threshold(const Eigen::VectorXd& d_dot);

}  // namespace rb
