// Block Gauss-Seidel: sweeps over the contacts in index order, each solved exactly (local_solver).
// Robust and cheap, but crawls on stacks: the first stage of contact_solver, or the whole of it for
// large islands.
#pragma once

#include <vector>

#include "contact/problem.hpp"
#include "solver/friction_cone.hpp"

namespace rb {

struct GaussSeidelWorkspace {
  std::vector<Mat3> w;          // W_ii, contact frame, 1/kg
  std::vector<Mat3> w_angular;  // the same for moments and spins, scaled by cone.length^2
};

// W_ii of all contacts.
void local_delassus(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                    GaussSeidelWorkspace& ws);

// Spinning (1D) and rolling (2D) moments of one contact for its present normal impulse: least
// kinetic energy within the bounds. w: w_angular[i]. Returns the change, scaled to m/s.
double solve_local_moment(const ContactProblem& problem, const ContactConstraint& contact,
                          const FrictionCone& cone, const Mat3& w, double normal, Vec3& moment,
                          std::vector<Vec6>& v);

// One sweep; impulse, moment and v are kept consistent. Returns the largest |w_i delta lambda_i|.
double gauss_seidel_sweep(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                          const GaussSeidelWorkspace& ws, std::vector<Vec3>& impulse,
                          std::vector<Vec3>& moment, std::vector<Vec6>& v);

}  // namespace rb
