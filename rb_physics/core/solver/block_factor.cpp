#include "solver/block_factor.hpp"

#include <cmath>

namespace rb {
namespace {

// In place: lower triangle becomes L, the diagonal holds 1 / L_kk.
bool cholesky(Mat6& a) {
  for (int k = 0; k < 6; ++k) {
    double d = a(k, k);
    for (int m = 0; m < k; ++m) d -= a(k, m) * a(k, m);
    if (!(d > 0.0) || !std::isfinite(d)) return false;
    const double inverse = 1.0 / std::sqrt(d);
    for (int i = k + 1; i < 6; ++i) {
      double s = a(i, k);
      for (int m = 0; m < k; ++m) s -= a(i, m) * a(k, m);
      a(i, k) = s * inverse;
    }
    a(k, k) = inverse;
  }
  return true;
}

// In place, by Gauss and Jordan with the largest pivot of each column: Eigen's LU of a 6x6 matrix
// takes the way of large ones, three times as long. False if a pivot is zero or not finite.
bool invert(Mat6& a) {
  int swapped[6];
  for (int k = 0; k < 6; ++k) {
    int best = k;
    for (int i = k + 1; i < 6; ++i) {
      if (std::abs(a(i, k)) > std::abs(a(best, k))) best = i;
    }
    swapped[k] = best;
    if (best != k) a.row(k).swap(a.row(best));
    const double inverse = 1.0 / a(k, k);
    if (!std::isfinite(inverse)) return false;
    const Vec6 column = a.col(k);
    a.col(k).setZero();
    a(k, k) = 1.0;
    a.row(k) *= inverse;
    for (int j = 0; j < 6; ++j) {
      const double pivot = a(k, j);
      for (int i = 0; i < 6; ++i) {
        if (i != k) a(i, j) -= column[i] * pivot;
      }
    }
  }
  for (int k = 5; k >= 0; --k) {
    if (swapped[k] != k) a.col(k).swap(a.col(swapped[k]));
  }
  return a.allFinite();
}

// B := B L^-T, column by column.
void solve_right_transposed(const Mat6& l, Mat6& b) {
  for (int k = 0; k < 6; ++k) {
    for (int m = 0; m < k; ++m) b.col(k) -= l(k, m) * b.col(m);
    b.col(k) *= l(k, k);
  }
}

void solve_lower(const Mat6& l, Vec6& x) {
  for (int k = 0; k < 6; ++k) {
    x[k] *= l(k, k);
    for (int i = k + 1; i < 6; ++i) x[i] -= l(i, k) * x[k];
  }
}

void solve_lower_transposed(const Mat6& l, Vec6& x) {
  for (int k = 5; k >= 0; --k) {
    double s = x[k];
    for (int i = k + 1; i < 6; ++i) s -= l(i, k) * x[i];
    x[k] = s * l(k, k);
  }
}

// x -= B^T y, number by number: y was stored that way just before, and loads of two would wait for
// it.
void subtract_transposed(const Mat6& b, const Vec6& y, Vec6& x) {
  for (int k = 0; k < 6; ++k) {
    double s = 0.0;
    for (int i = 0; i < 6; ++i) s += b(i, k) * y[i];
    x[k] -= s;
  }
}

}  // namespace

void BlockFactor::reset(const BodyGraph& graph, bool symmetric) {
  symmetric_ = symmetric;
  diagonal_.assign(graph.body_count(), Mat6::Identity());
  lower_.assign(graph.block_count(), Mat6::Zero());
  if (!symmetric) upper_.assign(graph.block_count(), Mat6::Zero());
}

bool BlockFactor::factorize(const BodyGraph& graph) {
  return symmetric_ ? factorize_symmetric(graph) : factorize_general(graph);
}

bool BlockFactor::factorize_symmetric(const BodyGraph& graph) {
  std::size_t target = 0;
  const std::vector<int>& targets = graph.update_targets();
  for (int j = 0; j < graph.body_count(); ++j) {
    if (!cholesky(diagonal_[j])) return false;
    const int begin = graph.column_begin(j);
    const int end = graph.column_begin(j + 1);
    for (int q = begin; q < end; ++q) solve_right_transposed(diagonal_[j], lower_[q]);
    for (int q = begin; q < end; ++q) {
      const Mat6& lq = lower_[q];
      diagonal_[graph.row(q)].noalias() -= lq * lq.transpose();
      for (int p = q + 1; p < end; ++p) {
        lower_[targets[target++]].noalias() -= lower_[p] * lq.transpose();
      }
    }
  }
  return true;
}

bool BlockFactor::factorize_general(const BodyGraph& graph) {
  std::size_t target = 0;
  const std::vector<int>& targets = graph.update_targets();
  for (int j = 0; j < graph.body_count(); ++j) {
    if (!invert(diagonal_[j])) return false;
    const Mat6& inverse = diagonal_[j];
    const int begin = graph.column_begin(j);
    const int end = graph.column_begin(j + 1);
    for (int q = begin; q < end; ++q) lower_[q] = (lower_[q] * inverse).eval();
    for (int q = begin; q < end; ++q) {
      diagonal_[graph.row(q)].noalias() -= lower_[q] * upper_[q];
      for (int p = q + 1; p < end; ++p) {
        const int t = targets[target++];
        lower_[t].noalias() -= lower_[p] * upper_[q];
        upper_[t].noalias() -= lower_[q] * upper_[p];
      }
    }
  }
  return true;
}

void BlockFactor::solve(const BodyGraph& graph, std::vector<Vec6>& x) const {
  const int nb = graph.body_count();
  for (int j = 0; j < nb; ++j) {
    if (symmetric_) solve_lower(diagonal_[j], x[j]);
    for (int q = graph.column_begin(j); q < graph.column_begin(j + 1); ++q) {
      x[graph.row(q)].noalias() -= lower_[q] * x[j];
    }
  }
  for (int j = nb - 1; j >= 0; --j) {
    for (int q = graph.column_begin(j); q < graph.column_begin(j + 1); ++q) {
      if (symmetric_) {
        subtract_transposed(lower_[q], x[graph.row(q)], x[j]);
      } else {
        x[j].noalias() -= upper_[q] * x[graph.row(q)];
      }
    }
    if (symmetric_) {
      solve_lower_transposed(diagonal_[j], x[j]);
    } else {
      x[j] = (diagonal_[j] * x[j]).eval();
    }
  }
}

}  // namespace rb
