#include "shape/compound.hpp"

#include <stdexcept>
#include <string>

namespace rb {

namespace {

constexpr std::size_t max_parts = 4096;  // what a feature id has room for (collision/feature.hpp)

void flatten(const CompoundPart& part, const Pose& parent, std::vector<CompoundPart>& leaves) {
  const Pose pose = parent * part.pose;
  if (const auto* inner = std::get_if<Compound>(&part.shape)) {
    for (const CompoundPart& leaf : inner->data->parts) flatten(leaf, pose, leaves);
    return;
  }
  if (std::holds_alternative<HalfSpace>(part.shape) ||
      std::holds_alternative<TriangleMesh>(part.shape) ||
      std::holds_alternative<HeightField>(part.shape)) {
    throw std::invalid_argument(std::string("a part is a ") + shape_name(part.shape) +
                                "; allowed are particle, sphere, box, capsule, cylinder, "
                                "convex_hull and compound; make it a static body of its own");
  }
  leaves.push_back({part.shape, {pose.position, pose.orientation.normalized()}});
}

}  // namespace

Compound make_compound(const std::vector<CompoundPart>& parts) {
  auto data = std::make_shared<CompoundData>();
  for (const CompoundPart& part : parts) flatten(part, Pose{}, data->parts);
  if (data->parts.empty()) {
    throw std::invalid_argument("at least one part is needed");
  }
  if (data->parts.size() > max_parts) {
    throw std::invalid_argument(std::to_string(data->parts.size()) + " parts; at most " +
                                std::to_string(max_parts) + " are allowed");
  }
  return Compound{std::move(data)};
}

}  // namespace rb
