// Manifolds that motion has not changed: what contacts were looked for with when they were looked
// for last. A pair whose bodies have not moved by a bit since, seen with the same margin, has the
// contacts it had. Holds no state: the contacts are the same to the bit without it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "body/material.hpp"
#include "contact/contact.hpp"
#include "world/island_workspace.hpp"

namespace rb {

struct World;

class PersistentManifolds {
 public:
  // The next detection looks at every pair.
  void forget() { known_ = false; }

  // The contacts of these bodies are no longer those of the last detection.
  void replace(std::span<const std::int32_t> rows) {
    if (!known_) return;
    for (const std::int32_t row : rows) replaced_[row] = 1;
  }

  // A detection begins: which bodies stayed where the last one found them. Takes the list of its
  // pairs; the new one is made next.
  void begin(World& world);
  void list_margins(const World& world);  // when it is made

  // Whether the body has not moved by a bit since the last detection.
  bool stayed(std::int32_t row) const { return stayed_[row] != 0; }

  // Whether pair k, which ends `contacts`, is worth keeping: features that stand there twice are
  // matched in another way.
  void looked_at(std::size_t k, double margin, std::span<const Contact> contacts, bool capped);

  // Whether pair k, seen with this margin (m), has the contacts it had.
  bool keeps(const World& world, std::size_t k, double margin) const;
  void set_margin(std::size_t k, double margin) { margins_[k] = margin; }
  // Whether all pairs have, and there is no other.
  bool keeps_all(const World& world);
  // Whether these contacts, of one pair, stand there as they were found.
  static bool as_found(std::span<const Contact> contacts);

 private:
  using Placement = std::array<double, 7>;  // x, q

  bool known_ = false;
  Combine friction_ = Combine::GEOMETRIC_MEAN, restitution_ = Combine::GEOMETRIC_MEAN;
  std::vector<Placement> placements_;   // per row, at the last detection
  std::vector<std::uint8_t> stayed_;    // per row
  std::vector<std::uint8_t> replaced_;  // per row
  std::vector<ColliderPair> old_pairs_;
  std::vector<double> old_margins_;  // m, per old pair; NaN: not to be kept
  std::vector<double> margins_;      // m, per pair of the world
};

}  // namespace rb
