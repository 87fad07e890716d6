#include "shape/shape.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "shape/height_field.hpp"
#include "shape/hull.hpp"
#include "shape/mesh.hpp"

namespace rb {

const char* shape_name(const Shape& shape) {
  static constexpr const char* names[] = {
      "particle",   "sphere",      "box",           "capsule",      "cylinder",
      "half_space", "convex_hull", "triangle_mesh", "height_field", "compound"};
  static_assert(std::size(names) == std::variant_size_v<Shape>);
  return names[shape.index()];
}

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

struct CharacteristicSize {
  double operator()(const Particle&) const { return 1.0; }
  double operator()(const Sphere& s) const { return s.radius; }
  double operator()(const Box& s) const { return s.half_extents.maxCoeff(); }
  double operator()(const Capsule& s) const { return s.radius + s.half_length; }
  double operator()(const Cylinder& s) const { return std::max(s.radius, s.half_length); }
  double operator()(const HalfSpace&) const { return 1.0; }
  double operator()(const ConvexHull& s) const { return s.data->size; }
  double operator()(const TriangleMesh& s) const { return s.data->size; }
  double operator()(const HeightField& s) const { return s.data->size; }
  double operator()(const Compound& s) const {
    double size = 0.0;
    for (const CompoundPart& part : s.data->parts) {
      size = std::max(size, part.pose.position.norm() + characteristic_size(part.shape));
    }
    return size;
  }
};

struct LeastWidth {
  double operator()(const Particle&) const { return 0.0; }
  double operator()(const Sphere& s) const { return 2.0 * s.radius; }
  double operator()(const Box& s) const { return 2.0 * s.half_extents.minCoeff(); }
  double operator()(const Capsule& s) const { return 2.0 * s.radius; }
  double operator()(const Cylinder& s) const { return 2.0 * std::min(s.radius, s.half_length); }
  double operator()(const HalfSpace&) const { return infinity; }
  double operator()(const ConvexHull& s) const {
    double least = infinity;
    for (const HullFace& face : s.data->faces) {
      double width = 0.0;
      for (const Vec3& vertex : s.data->vertices) {
        width = std::max(width, face.offset - face.normal.dot(vertex));
      }
      least = std::min(least, width);
    }
    return least;
  }
  double operator()(const TriangleMesh&) const { return 0.0; }
  double operator()(const HeightField&) const { return infinity; }
  double operator()(const Compound& s) const {
    double least = infinity;
    for (const CompoundPart& part : s.data->parts) {
      least = std::min(least, least_width(part.shape));
    }
    return least;
  }
};

}  // namespace

double least_width(const Shape& shape) { return std::visit(LeastWidth{}, shape); }

double characteristic_size(const Shape& shape) { return std::visit(CharacteristicSize{}, shape); }

}  // namespace rb
