#include "island/island.hpp"

namespace rb {

std::int32_t Islands::find(std::int32_t row) {
  while (parent_[row] != row) {
    parent_[row] = parent_[parent_[row]];
    row = parent_[row];
  }
  return row;
}

void Islands::build(const std::vector<std::uint8_t>& movable,
                    const std::vector<std::pair<std::int32_t, std::int32_t>>& edges) {
  const auto n = static_cast<std::int32_t>(movable.size());
  parent_.resize(n);
  for (std::int32_t i = 0; i < n; ++i) parent_[i] = i;
  std::pair<std::int32_t, std::int32_t> last{-1, -1};  // mostly there are several of a pair
  for (const auto& edge : edges) {
    const auto& [a, b] = edge;
    if (edge == last || !movable[a] || !movable[b]) continue;
    last = edge;
    const std::int32_t ra = find(a);
    const std::int32_t rb = find(b);
    // The lowest row is the root: the numbering does not depend on the order of the edges.
    if (ra < rb)
      parent_[rb] = ra;
    else if (rb < ra)
      parent_[ra] = rb;
  }
  islands_.clear();
  label_.assign(n, -1);
  for (std::int32_t i = 0; i < n; ++i) {
    if (!movable[i]) continue;
    const std::int32_t root = find(i);
    if (root == i) {
      label_[i] = static_cast<std::int32_t>(islands_.size());
      islands_.push_back({});
    }
    label_[i] = label_[root];
    ++islands_[label_[i]].body_count;
  }
  const auto island_of = [&](const std::pair<std::int32_t, std::int32_t>& e) {
    return movable[e.first] ? label_[e.first] : label_[e.second];
  };
  // visit(first, end, island) of runs of equal edges that are of one.
  const auto for_runs = [&](const auto& visit) {
    const auto n = static_cast<std::int32_t>(edges.size());
    for (std::int32_t k = 0; k < n;) {
      const std::int32_t first = k;
      while (++k < n && edges[k] == edges[first]) {
      }
      const std::int32_t label = island_of(edges[first]);
      if (label >= 0) visit(first, k, label);
    }
  };
  for_runs([&](std::int32_t first, std::int32_t end, std::int32_t label) {
    islands_[label].edge_count += end - first;
  });
  std::int32_t body_total = 0;
  std::int32_t edge_total = 0;
  for (Island& island : islands_) {
    island.first_body = body_total;
    island.first_edge = edge_total;
    body_total += island.body_count;
    edge_total += island.edge_count;
  }
  bodies_.resize(body_total);
  edges_.resize(edge_total);
  fill_.assign(2 * islands_.size(), 0);
  for (std::int32_t i = 0; i < n; ++i) {
    if (label_[i] < 0) continue;
    const Island& island = islands_[label_[i]];
    bodies_[island.first_body + fill_[2 * label_[i]]++] = i;
  }
  for_runs([&](std::int32_t first, std::int32_t end, std::int32_t label) {
    std::int32_t at = islands_[label].first_edge + fill_[2 * label + 1];
    for (std::int32_t k = first; k < end; ++k) edges_[at++] = k;
    fill_[2 * label + 1] += end - first;
  });
}

}  // namespace rb
