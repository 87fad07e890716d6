// The normal rows of the contact problem as a dense matrix: A_ij = speed along N_i at contact i per
// unit impulse along N_j at contact j (S14), 1/kg; and the speeds d_dot themselves.
#pragma once

#include <Eigen/Core>

#include "contact/problem.hpp"

namespace rb {

Eigen::MatrixXd normal_delassus(const ContactProblem& problem);

// d_dot_i = u_n of velocity v, m/s.
Eigen::VectorXd normal_speeds(const ContactProblem& problem, const std::vector<Vec6>& v);

// v += M^-1 N^T f.
void apply_normal_impulses(const ContactProblem& problem, const Eigen::VectorXd& f,
                           std::vector<Vec6>& v);

}  // namespace rb
