// Factorisation of a body-space matrix with 6x6 blocks on a BodyGraph: Cholesky L L^T when it is
// symmetric positive definite, block LU (pivoting inside the blocks) when friction makes it
// unsymmetric.
#pragma once

#include <vector>

#include "solver/body_graph.hpp"

namespace rb {

class BlockFactor {
 public:
  // Sizes the storage and sets the matrix to the identity. Allocates only when it grows.
  void reset(const BodyGraph& graph, bool symmetric);

  Mat6& diagonal(int position) { return diagonal_[position]; }
  Mat6& lower(int block) { return lower_[block]; }  // A(row, column)
  Mat6& upper(int block) { return upper_[block]; }  // A(column, row); unsymmetric only
  bool symmetric() const { return symmetric_; }

  // False if a pivot block is singular or not finite.
  bool factorize(const BodyGraph& graph);

  // x (by elimination position) := A^-1 x.
  void solve(const BodyGraph& graph, std::vector<Vec6>& x) const;

 private:
  bool factorize_symmetric(const BodyGraph& graph);
  bool factorize_general(const BodyGraph& graph);

  bool symmetric_ = true;
  std::vector<Mat6> diagonal_;  // after factorising: L_jj, or A_jj^-1 (general)
  std::vector<Mat6> lower_, upper_;
};

}  // namespace rb
