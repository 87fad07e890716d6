#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

#include "solver/lcp.hpp"

namespace rb {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kDelta = 1e-9;  // proximal term, relative to the mean diagonal
constexpr int kBlockTries = 10;  // block exchanges without progress before Murty's rule
constexpr int kRefinements = 20;

// One strictly convex LCP (p = M + delta I, q) from the index set `positive` of z > 0, kept.
// Returns the pivots done, negative if the limit was met.
int solve_positive_definite(const MatrixXd& p, const VectorXd& q, std::vector<char>& positive,
                            VectorXd& z, VectorXd& w) {
  const Index n = q.size();
  const int max_pivots = 100 * static_cast<int>(n) + 100;
  Index least_wrong = n + 1;
  int tries = kBlockTries;
  std::vector<Index> set;
  for (int pivots = 1; pivots <= max_pivots; ++pivots) {
    set.clear();
    for (Index i = 0; i < n; ++i) {
      if (positive[i]) set.push_back(i);
    }
    z.setZero(n);
    if (!set.empty()) {
      const VectorXd x = p(set, set).llt().solve(-q(set));
      z(set) = x;
    }
    w = p * z + q;
    const double tiny_w = 1e-15 * q.cwiseAbs().maxCoeff();
    const double tiny_z = 1e-15 * z.cwiseAbs().maxCoeff();
    Index wrong = 0;
    Index last = -1;
    for (Index i = 0; i < n; ++i) {
      if (positive[i] ? z[i] < -tiny_z : w[i] < -tiny_w) {
        ++wrong;
        last = i;
      }
    }
    if (wrong == 0) return pivots;
    bool block = true;
    if (wrong < least_wrong) {
      least_wrong = wrong;
      tries = kBlockTries;
    } else if (tries > 0) {
      --tries;
    } else {
      block = false;  // Murty: exchange one index, finite for a positive definite matrix
    }
    for (Index i = 0; i < n; ++i) {
      const bool is_wrong = positive[i] ? z[i] < -tiny_z : w[i] < -tiny_w;
      if (is_wrong && (block || i == last)) positive[i] = !positive[i];
    }
  }
  return -max_pivots;
}

// The least of all solutions with these indices positive, to rounding; kept only if it is one.
void least_norm(const MatrixXd& m, const VectorXd& q, const std::vector<char>& positive,
                LcpResult& result) {
  std::vector<Index> set;
  for (Index i = 0; i < q.size(); ++i) {
    if (positive[i]) set.push_back(i);
  }
  if (set.empty()) return;
  const MatrixXd block = m(set, set);
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> qr;
  qr.setThreshold(1e-12);
  qr.compute(block);
  VectorXd x = qr.solve(-q(set));
  x += qr.solve(-q(set) - block * x);
  if (!(x.minCoeff() >= 0.0)) return;
  VectorXd z = VectorXd::Zero(q.size());
  z(set) = x;
  if (lcp_residual(m, q, z) <= std::max(4.0 * lcp_residual(m, q, result.z), 1e-14)) result.z = z;
}

}  // namespace

LcpResult lcp_pivoting(const MatrixXd& m, const VectorXd& q) {
  const Index n = q.size();
  LcpResult result;
  result.z = VectorXd::Zero(n);
  if (n == 0 || q.minCoeff() >= 0.0) {
    result.solved = true;
    return result;
  }
  const double delta = kDelta * m.trace() / static_cast<double>(n);
  MatrixXd p = m;
  p.diagonal().array() += delta;
  std::vector<char> positive(n, 0);
  VectorXd z, w;
  VectorXd shifted = q;
  double best = -1.0;
  for (int k = 0; k < kRefinements; ++k) {
    const int pivots = solve_positive_definite(p, shifted, positive, z, w);
    result.pivots += std::abs(pivots);
    if (pivots < 0) break;
    z = z.cwiseMax(0.0);
    const double residual = lcp_residual(m, q, z);
    if (best >= 0.0 && residual >= 0.5 * best) {
      if (residual < best) result.z = z;
      break;
    }
    best = residual;
    result.z = z;
    if (residual == 0.0) break;
    shifted = q - delta * z;
  }
  least_norm(m, q, positive, result);
  result.residual = lcp_residual(m, q, result.z);
  result.solved = best >= 0.0 && result.residual <= 1e-9;
  return result;
}

}  // namespace rb
