// A triangle made solid: its prism behind the face, as a convex hull for the convex pair functions.
#pragma once

#include <array>
#include <memory>

#include "collision/feature.hpp"
#include "shape/hull.hpp"
#include "shape/shape.hpp"
#include "shape/triangle.hpp"

namespace rb {

// Which part of the triangle a feature of the prism is; NONE for its sides and back.
struct PrismFeature {
  enum Kind { FACE, EDGE, CORNER, NONE } kind;
  int index;  // of the edge or corner
};

class TrianglePrism {
 public:
  TrianglePrism();

  // The prism of `triangle` with this thickness (m > 0) in the triangle's coordinates.
  const Shape& place(const SurfaceTriangle& triangle, double thickness);

  PrismFeature feature(std::uint32_t id) const;  // of the hull's half of a contact's feature id

 private:
  std::shared_ptr<HullData> hull_;
  Shape shape_;                   // shares hull_
  std::array<int, 9> edge_of_{};  // hull edge -> triangle edge, -1 for none
};

}  // namespace rb
