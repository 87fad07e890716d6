// Islands: groups of dynamic bodies connected by pairs that may touch. Static and kinematic bodies
// connect nothing. Islands, their bodies and their pairs come in index order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace rb {

struct Island {
  std::int32_t first_body = 0, body_count = 0;  // range in Islands::bodies
  std::int32_t first_edge = 0, edge_count = 0;  // range in Islands::edges
};

class Islands {
 public:
  // nodes: number of rows; movable[row]; edges (a, b) of rows, b may be immovable.
  void build(const std::vector<std::uint8_t>& movable,
             const std::vector<std::pair<std::int32_t, std::int32_t>>& edges);

  const std::vector<Island>& all() const { return islands_; }
  std::span<const std::int32_t> bodies(const Island& i) const {
    return {bodies_.data() + i.first_body, static_cast<std::size_t>(i.body_count)};
  }
  // That of a row that can move.
  const Island& of(std::int32_t row) const { return islands_[label_[row]]; }
  // Indices into the edge list given to build, ascending.
  std::span<const std::int32_t> edges(const Island& i) const {
    return {edges_.data() + i.first_edge, static_cast<std::size_t>(i.edge_count)};
  }

 private:
  std::int32_t find(std::int32_t row);

  std::vector<std::int32_t> parent_, label_, bodies_, edges_, fill_;
  std::vector<Island> islands_;
};

}  // namespace rb
