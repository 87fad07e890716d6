#include "collision/extent.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "shape/hull.hpp"

namespace rb {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

struct LocalExtent {
  const Vec3& d;  // body coordinates

  double operator()(const Particle&) const { return 0.0; }
  double operator()(const Sphere& s) const { return s.radius * d.norm(); }
  double operator()(const Box& s) const { return s.half_extents.dot(d.cwiseAbs()); }
  double operator()(const Capsule& s) const {
    return s.radius * d.norm() + s.half_length * std::abs(d.z());
  }
  double operator()(const Cylinder& s) const {
    return s.radius * d.head<2>().norm() + s.half_length * std::abs(d.z());
  }
  double operator()(const HalfSpace& s) const {
    return (d - s.normal).squaredNorm() < 1e-24 ? s.offset : infinity;
  }
  double operator()(const ConvexHull& s) const {
    double farthest = -infinity;
    for (const Vec3& v : s.data->vertices) farthest = std::max(farthest, d.dot(v));
    return farthest;
  }
  template <class Other>
  double operator()(const Other& s) const {
    throw std::invalid_argument(std::string("extent: ") + shape_name(Shape(s)) + " is not convex");
  }
};

}  // namespace

double extent(const Shape& shape, const Pose& pose, const Vec3& direction) {
  const Vec3 local = pose.rotate_inverse(direction);
  return direction.dot(pose.position) + std::visit(LocalExtent{local}, shape);
}

}  // namespace rb
