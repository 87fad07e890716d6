// The part of an island about some of its contacts.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "world/world.hpp"

namespace rb {

// Lists the bodies of the contacts (of those listed, and active) that meet the condition, and those
// within some contacts of them, as rows in ascending order; and all active contacts that any of
// these has.
template <class Condition>
void find_neighbourhood(const World& world, std::span<const std::int32_t> contacts,
                        const Condition& condition, std::vector<std::int32_t>& rows,
                        std::vector<std::int32_t>& of_them) {
  constexpr int rings = 3;
  static thread_local std::vector<std::uint8_t> ring;  // 0: far away; else the last first
  const auto can_move = [&](std::int32_t row) { return world.bodies[row].is_dynamic(); };
  ring.assign(world.bodies.size(), 0);
  for (const std::int32_t i : contacts) {
    const Contact& c = world.contacts[i];
    if (!c.active() || !condition(c)) continue;
    ring[c.body_a] = ring[c.body_b] = rings + 1;
  }
  for (int left = rings; left > 0; --left) {
    for (const std::int32_t i : contacts) {
      const auto& [a, b] = world.work.edges[i];
      if (!can_move(b)) continue;
      if (ring[a] == left + 1 && ring[b] == 0) ring[b] = static_cast<std::uint8_t>(left);
      if (ring[b] == left + 1 && ring[a] == 0) ring[a] = static_cast<std::uint8_t>(left);
    }
  }
  rows.clear();
  of_them.clear();
  for (std::size_t row = 0; row < ring.size(); ++row) {
    if (!can_move(static_cast<std::int32_t>(row))) ring[row] = 0;
    if (ring[row] != 0) rows.push_back(static_cast<std::int32_t>(row));
  }
  for (const std::int32_t i : contacts) {
    const auto& [a, b] = world.work.edges[i];
    if ((ring[a] != 0 || ring[b] != 0) && world.contacts[i].active()) of_them.push_back(i);
  }
}

}  // namespace rb
