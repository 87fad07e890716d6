#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "solver/lcp.hpp"

namespace rb {
namespace {

// Tableau of  w - M z - d z0 = q  with columns w (0 .. n-1), z (n .. 2n-1), z0 (2n), q (2n+1).
// The w columns carry the inverse of the basis, which the lexicographic rule compares.
class Tableau {
 public:
  Tableau(const Eigen::MatrixXd& m, const Eigen::VectorXd& q)
      : n_(q.size()), t_(n_, 2 * n_ + 2), basis_(n_) {
    t_.leftCols(n_).setIdentity();
    t_.middleCols(n_, n_) = -m;
    t_.col(2 * n_).setConstant(-1.0);
    t_.col(2 * n_ + 1) = q;
    for (Eigen::Index i = 0; i < n_; ++i) basis_[i] = i;
  }

  Eigen::Index artificial() const { return 2 * n_; }
  Eigen::Index basis(Eigen::Index row) const { return basis_[row]; }
  double value(Eigen::Index row) const { return t_(row, 2 * n_ + 1); }

  Eigen::Index most_negative_row() const {
    Eigen::Index row = 0;
    for (Eigen::Index i = 1; i < n_; ++i) {
      if (value(i) < value(row)) row = i;
    }
    return row;
  }

  // Row leaving when `column` enters; -1: unbounded ray. Least ratio in the lexicographic order of
  // (q, B^-1); the artificial variable leaves whenever it may.
  Eigen::Index leaving_row(Eigen::Index column) const {
    Eigen::Index best = -1;
    const double tiny = 1e-11 * t_.col(column).cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < n_; ++i) {
      if (!(t_(i, column) > tiny)) continue;
      if (best < 0 || lexicographically_less(i, best, column)) best = i;
    }
    if (best < 0) return best;
    for (Eigen::Index i = 0; i < n_; ++i) {
      if (basis_[i] != artificial() || !(t_(i, column) > tiny)) continue;
      const double slack = value(i) / t_(i, column) - value(best) / t_(best, column);
      if (slack <= 1e-14 * std::abs(value(i) / t_(i, column))) best = i;
    }
    return best;
  }

  Eigen::Index pivot(Eigen::Index row, Eigen::Index column) {
    t_.row(row) /= t_(row, column);
    t_(row, column) = 1.0;
    for (Eigen::Index i = 0; i < n_; ++i) {
      if (i == row) continue;
      const double factor = t_(i, column);
      if (factor == 0.0) continue;
      t_.row(i) -= factor * t_.row(row);
      t_(i, column) = 0.0;
    }
    const Eigen::Index left = basis_[row];
    basis_[row] = column;
    return left;
  }

  Eigen::Index complement(Eigen::Index variable) const {
    return variable < n_ ? variable + n_ : variable - n_;
  }

 private:
  bool lexicographically_less(Eigen::Index i, Eigen::Index k, Eigen::Index column) const {
    const double a = t_(i, column);
    const double b = t_(k, column);
    const double q = value(i) * b - value(k) * a;
    if (std::abs(q) > 1e-13 * (std::abs(value(i) * b) + std::abs(value(k) * a))) return q < 0.0;
    for (Eigen::Index j = 0; j < n_; ++j) {
      const double x = t_(i, j) * b;
      const double y = t_(k, j) * a;
      if (std::abs(x - y) > 1e-12 * (std::abs(x) + std::abs(y))) return x < y;
    }
    return false;
  }

  Eigen::Index n_;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> t_;
  std::vector<Eigen::Index> basis_;
};

// What is positive, from M and q themselves: a tableau keeps the rounding of every pivot. Kept if
// it is nearer.
void solve_anew(const Eigen::MatrixXd& m, const Eigen::VectorXd& q, LcpResult& result) {
  std::vector<Eigen::Index> set;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (result.z[i] > 0.0) set.push_back(i);
  }
  if (set.empty()) return;
  const Eigen::PartialPivLU<Eigen::MatrixXd> lu(m(set, set));
  Eigen::VectorXd z = Eigen::VectorXd::Zero(q.size());
  z(set) = lu.solve(-q(set)).cwiseMax(0.0);
  const double residual = lcp_residual(m, q, z);
  if (!(residual < result.residual)) return;
  result.z = z;
  result.residual = residual;
}

}  // namespace

LcpResult lcp_lemke(const Eigen::MatrixXd& m, const Eigen::VectorXd& q) {
  const Eigen::Index n = q.size();
  LcpResult result;
  result.z = Eigen::VectorXd::Zero(n);
  if (n == 0 || q.minCoeff() >= 0.0) {
    result.solved = true;
    return result;
  }
  Tableau tableau(m, q);
  Eigen::Index left = tableau.pivot(tableau.most_negative_row(), tableau.artificial());
  const int max_pivots = 50 * static_cast<int>(n) + 100;
  result.pivots = 1;
  while (left != tableau.artificial() && result.pivots < max_pivots) {
    const Eigen::Index entering = tableau.complement(left);
    const Eigen::Index row = tableau.leaving_row(entering);
    if (row < 0) break;
    left = tableau.pivot(row, entering);
    ++result.pivots;
  }
  result.solved = left == tableau.artificial();
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index v = tableau.basis(i);
    if (v >= n && v < 2 * n) result.z[v - n] = std::max(tableau.value(i), 0.0);
  }
  result.residual = lcp_residual(m, q, result.z);
  if (result.solved) solve_anew(m, q, result);
  return result;
}

}  // namespace rb
