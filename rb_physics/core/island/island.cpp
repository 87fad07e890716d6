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
  for (const auto& [a, b] : edges) {
    if (!movable[a] || !movable[b]) continue;
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
  for (const auto& e : edges) {
    if (island_of(e) >= 0) ++islands_[island_of(e)].edge_count;
  }
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
  for (std::int32_t k = 0; k < static_cast<std::int32_t>(edges.size()); ++k) {
    const std::int32_t label = island_of(edges[k]);
    if (label < 0) continue;
    edges_[islands_[label].first_edge + fill_[2 * label + 1]++] = k;
  }
}

}  // namespace rb
