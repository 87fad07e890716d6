// Linear complementarity problem, dense:  w = M z + q,  w >= 0,  z >= 0,  z . w = 0.
//
// M is positive semidefinite here (Delassus matrices, KKT systems of convex problems). Outputs are
// valid if and only if `solved`; the residual judges both methods.
#pragma once

#include <Eigen/Core>

namespace rb {

struct LcpResult {
  Eigen::VectorXd z;
  double residual = 0.0;  // lcp_residual of z
  int pivots = 0;
  bool solved = false;
};

// max_i |min(m_i z_i, w_i)| / max_i |q_i|, m_i = max(M_ii, mean diagonal / n): no unit, 0 when
// solved.
double lcp_residual(const Eigen::MatrixXd& m, const Eigen::VectorXd& q, const Eigen::VectorXd& z);

// Lemke 1965 with the lexicographic rule against cycling (Cottle, Pang & Stone 1992, ch. 4): finite
// for every positive semidefinite M, degenerate ones included. O(n^3): the reference.
LcpResult lcp_lemke(const Eigen::MatrixXd& m, const Eigen::VectorXd& q);

// Block principal pivoting (Judice & Pires 1994) with Murty's least-index rule as the safeguard, on
// M + delta I, refined to the limit by proximal steps: also redundant (singular) problems, of whose
// solutions it gives the one of least norm. The method for daily use.
LcpResult lcp_pivoting(const Eigen::MatrixXd& m, const Eigen::VectorXd& q);

}  // namespace rb
