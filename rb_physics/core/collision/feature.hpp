// Names of the features that met. A shape's feature has 31 bits, part | type | index; a contact's
// id packs both, A's first, so that swapping the bodies swaps the halves.
#pragma once

#include <cstdint>

namespace rb {

enum class FeatureType : std::uint32_t { VERTEX = 0, EDGE = 1, FACE = 2, SMOOTH = 3 };

// Box: vertex index has bit i set where coordinate i is positive; edge index is 4 * axis + sign
// bits of the next two axes; face index is 2 * axis + (positive). Hull: indices into HullData.
// Half-space: FACE 0. Sphere: SMOOTH 0. Particle: VERTEX 0. Capsule: SMOOTH 0 / 1 the ends at +z /
// -z, 2 the side. Cylinder: FACE 0 / 1 the caps at +z / -z, SMOOTH 2 the side, SMOOTH 0 / 1 the
// rims, EDGE k a numbered point of a rim or side line.
inline constexpr int feature_index_bits = 17;
inline constexpr int feature_part_shift = 19;
inline constexpr int feature_bits = 31;

constexpr std::uint32_t make_feature(FeatureType type, std::uint32_t index) {
  return (static_cast<std::uint32_t>(type) << feature_index_bits) | index;
}
constexpr std::uint32_t with_part(std::uint32_t feature, std::uint32_t part) {
  return feature | (part << feature_part_shift);
}
constexpr std::int64_t pack_features(std::uint32_t a, std::uint32_t b) {
  return (static_cast<std::int64_t>(a) << feature_bits) | static_cast<std::int64_t>(b);
}

constexpr std::uint32_t feature_of_a(std::int64_t id) {
  return static_cast<std::uint32_t>(id >> feature_bits);
}
constexpr std::uint32_t feature_of_b(std::int64_t id) {
  return static_cast<std::uint32_t>(id & ((std::int64_t{1} << feature_bits) - 1));
}
constexpr FeatureType feature_type(std::uint32_t feature) {
  return static_cast<FeatureType>((feature >> feature_index_bits) & 3u);
}
constexpr std::uint32_t feature_index(std::uint32_t feature) {
  return feature & ((1u << feature_index_bits) - 1);
}
constexpr std::uint32_t feature_part(std::uint32_t feature) {
  return feature >> feature_part_shift;
}

}  // namespace rb
