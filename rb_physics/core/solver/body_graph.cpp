#include "solver/body_graph.hpp"

#include <algorithm>

namespace rb {
namespace {

void insert_sorted(std::vector<int>& list, int value) {
  const auto at = std::lower_bound(list.begin(), list.end(), value);
  if (at == list.end() || *at != value) list.insert(at, value);
}

void erase_sorted(std::vector<int>& list, int value) {
  const auto at = std::lower_bound(list.begin(), list.end(), value);
  if (at != list.end() && *at == value) list.erase(at);
}

// Multiply-adds to eliminate one body with `degree` remaining neighbours, 6x6 blocks.
double elimination_work(double degree) {
  return 90.0 + 126.0 * degree + 216.0 * 0.5 * degree * (degree + 1);
}

}  // namespace

bool BodyGraph::analyze(const ContactProblem& problem, double max_work) {
  const int nb = static_cast<int>(problem.inv_mass.size());
  const std::size_t nc = problem.contacts.size();
  bool same = nb == body_count() && pairs_.size() == nc && analyzed_for_ == max_work;
  for (std::size_t i = 0; same && i < nc; ++i) {
    same = pairs_[i].first == problem.contacts[i].a && pairs_[i].second == problem.contacts[i].b;
  }
  if (same) return usable_;

  pairs_.resize(nc);
  analyzed_for_ = max_work;
  usable_ = false;
  std::size_t blocks = 0;  // off the diagonal, before any fill
  for (std::size_t i = 0; i < nc; ++i) {
    pairs_[i] = {problem.contacts[i].a, problem.contacts[i].b};
    if (pairs_[i].second >= 0 && (i == 0 || pairs_[i - 1] != pairs_[i])) ++blocks;
  }
  // Every block is some body's when that is eliminated, and the work is convex in their count.
  const double mean = static_cast<double>(blocks) / nb;
  if (nb > 0 && nb * elimination_work(mean) > max_work) return false;
  for (std::vector<int>& n : neighbours_) n.clear();
  neighbours_.resize(nb);
  for (std::size_t i = 0; i < nc; ++i) {
    const auto& [a, b] = pairs_[i];
    if (b < 0 || (i > 0 && pairs_[i - 1] == pairs_[i])) continue;
    insert_sorted(neighbours_[a], b);
    insert_sorted(neighbours_[b], a);
  }
  position_.assign(nb, -1);
  work_ = 0.0;
  order(nb, max_work);
  usable_ = work_ <= max_work && build_columns(nb, max_work);
  if (!usable_) return false;

  pair_block_.resize(nc);
  for (std::size_t i = 0; i < nc; ++i) {
    if (pairs_[i].second < 0) {
      pair_block_[i] = -1;
      continue;
    }
    const int p = position_[pairs_[i].first];
    const int q = position_[pairs_[i].second];
    pair_block_[i] = find_block(std::max(p, q), std::min(p, q));
  }
  return true;
}

void BodyGraph::order(int nb, double max_work) {
  sequence_.clear();
  for (std::vector<int>& rows : column_rows_) rows.clear();
  column_rows_.resize(nb);
  std::vector<std::vector<int>> by_degree(1);  // bodies that had this degree, lazily cleaned
  std::vector<std::pair<int, int>> heap;       // (degree, body): smallest first
  const auto later = [](const std::pair<int, int>& x, const std::pair<int, int>& y) {
    return x > y;
  };
  for (int i = 0; i < nb; ++i) heap.emplace_back(static_cast<int>(neighbours_[i].size()), i);
  std::make_heap(heap.begin(), heap.end(), later);
  while (!heap.empty()) {
    const auto [degree, body] = heap.front();
    std::pop_heap(heap.begin(), heap.end(), later);
    heap.pop_back();
    if (position_[body] >= 0 || degree != static_cast<int>(neighbours_[body].size())) continue;
    work_ += elimination_work(degree);
    if (work_ > max_work) return;
    const int at = static_cast<int>(sequence_.size());
    position_[body] = at;
    sequence_.push_back(body);
    column_rows_[at] = neighbours_[body];
    const std::vector<int>& clique = column_rows_[at];
    for (const int i : clique) {
      erase_sorted(neighbours_[i], body);
      for (const int k : clique) {
        if (k != i) insert_sorted(neighbours_[i], k);
      }
      heap.emplace_back(static_cast<int>(neighbours_[i].size()), i);
      std::push_heap(heap.begin(), heap.end(), later);
    }
  }
}

bool BodyGraph::build_columns(int nb, double max_work) {
  (void)max_work;
  columns_.assign(1, 0);
  rows_.clear();
  for (int j = 0; j < nb; ++j) {
    for (int& r : column_rows_[j]) r = position_[r];
    std::sort(column_rows_[j].begin(), column_rows_[j].end());
    rows_.insert(rows_.end(), column_rows_[j].begin(), column_rows_[j].end());
    columns_.push_back(static_cast<int>(rows_.size()));
  }
  targets_.clear();
  for (int j = 0; j < nb; ++j) {
    for (int q = columns_[j]; q < columns_[j + 1]; ++q) {
      for (int p = q + 1; p < columns_[j + 1]; ++p) {
        targets_.push_back(find_block(rows_[p], rows_[q]));
      }
    }
  }
  return true;
}

int BodyGraph::find_block(int row, int column) const {
  const auto begin = rows_.begin() + columns_[column];
  const auto end = rows_.begin() + columns_[column + 1];
  return static_cast<int>(std::lower_bound(begin, end, row) - rows_.begin());
}

}  // namespace rb
