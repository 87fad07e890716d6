// The sparsity of body-space matrices M + J^T D J: one 6x6 block per body and per pair in contact,
// in an elimination order that keeps fill small (minimum degree; ties to the lower index, so that
// the order is a function of the graph alone). A tower is eliminated without fill.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "contact/problem.hpp"

namespace rb {

class BodyGraph {
 public:
  // Analyses the problem's graph; does nothing when bodies and pairs are those of the last call.
  // Returns false, with the analysis unusable, once the factorisation would exceed max_work
  // multiply-adds.
  bool analyze(const ContactProblem& problem, double max_work);

  int body_count() const { return static_cast<int>(position_.size()); }
  // Off-diagonal blocks of the factor, fill included.
  int block_count() const { return static_cast<int>(rows_.size()); }
  double factor_work() const { return work_; }  // multiply-adds of one symmetric factorisation
  // Many contacts, and every body among many others: not a tower.
  bool is_jam() const {
    constexpr std::size_t few = 64;
    constexpr double tower = 150.0;  // multiply-adds per contact
    return usable_ && pairs_.size() > few && work_ > tower * static_cast<double>(pairs_.size());
  }

  // Elimination position of a body, 0 ... nb - 1.
  int position(int body) const { return position_[body]; }
  // Block of contact i's pair, below the diagonal; -1 when b = -1. Row is the later one of the two.
  int pair_block(int contact) const { return pair_block_[contact]; }

  // Column j of the factor: blocks column_begin(j) ... column_begin(j + 1) - 1, rows ascending.
  int column_begin(int j) const { return columns_[j]; }
  int row(int block) const { return rows_[block]; }
  // Where the update of rows (p, q), p > q, of column j lands: blocks listed column by column, for
  // each q ascending, for each p > q ascending.
  const std::vector<int>& update_targets() const { return targets_; }

 private:
  void order(int nb, double max_work);
  bool build_columns(int nb, double max_work);
  int find_block(int row, int column) const;

  std::vector<std::pair<int, int>> pairs_;     // (a, b) of every contact, the key of the cache
  std::vector<std::vector<int>> neighbours_;   // elimination graph
  std::vector<std::vector<int>> column_rows_;  // by position, rows as bodies, then as positions
  std::vector<int> sequence_;                  // body at each position
  std::vector<int> position_, columns_, rows_, targets_, pair_block_;
  double work_ = 0.0;
  bool usable_ = false;
  double analyzed_for_ = 0.0;
};

}  // namespace rb
