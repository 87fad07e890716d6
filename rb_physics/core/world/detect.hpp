// Contact detection for the whole world, and the parts of it that a step needs between two contact
// times.
#pragma once

#include <span>
#include <vector>

#include "collision/feature.hpp"
#include "math/tolerances.hpp"
#include "world/world.hpp"

namespace rb {

// m: separation up to which bodies of this size touch.
inline double touch_distance(double size) { return tolerance::touch * size; }

// The feature id with the indices of the two colliders within their bodies.
inline std::int64_t with_parts(std::int64_t feature, std::int32_t part_a, std::int32_t part_b) {
  if (part_a == 0 && part_b == 0) return feature;
  return pack_features(with_part(feature_of_a(feature), static_cast<std::uint32_t>(part_a)),
                       with_part(feature_of_b(feature), static_cast<std::uint32_t>(part_b)));
}

// m: how far apart the pair's surfaces may be and still meet within the step.
double pair_margin(const World& world, const ColliderPair& pair);

// Narrow phase of one pair at the bodies' present poses.
void append_contacts(const World& world, const ColliderPair& pair, double margin,
                     ContactPoints& scratch, std::vector<Contact>& out);

// Hands impulses and warm starts of `old` to the points of `fresh` with the same feature id (both
// ordered by pair). Points that carried an impulse and are gone are appended to `departed`.
void carry_over(std::span<const Contact> old, std::span<Contact> fresh,
                std::vector<Contact>* departed);

// Moves the two points of a contact with their bodies: the geometry of a point that has parted.
void follow_bodies(const World& world, Contact& contact);

// Broad phase: world.pairs.
void find_pairs(World& world);

// True when wrenches changed so much that bodies may travel farther than the last detection looked.
bool travel_grew(const World& world);

}  // namespace rb
