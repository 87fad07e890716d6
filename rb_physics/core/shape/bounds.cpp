// Bounding boxes and bounding radii of placed shapes.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "shape/height_field.hpp"
#include "shape/hull.hpp"
#include "shape/mesh.hpp"
#include "shape/shape.hpp"

namespace rb {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

Aabb around(const Vec3& center, const Vec3& half_extents) {
  return {center - half_extents, center + half_extents};
}

struct BoundingBox {
  const Pose& pose;

  Aabb operator()(const Particle&) const { return {pose.position, pose.position}; }
  Aabb operator()(const Sphere& s) const { return around(pose.position, Vec3::Constant(s.radius)); }
  Aabb operator()(const Box& s) const {
    const Mat3 rotation = pose.orientation.toRotationMatrix();
    return around(pose.position, rotation.cwiseAbs() * s.half_extents);
  }
  Aabb operator()(const Capsule& s) const {
    const Vec3 axis = pose.rotate(Vec3::UnitZ()).cwiseAbs();
    return around(pose.position, s.half_length * axis + Vec3::Constant(s.radius));
  }
  Aabb operator()(const Cylinder& s) const {
    const Vec3 a = pose.rotate(Vec3::UnitZ());
    const Vec3 rim(std::sqrt(a.y() * a.y() + a.z() * a.z()),
                   std::sqrt(a.x() * a.x() + a.z() * a.z()),
                   std::sqrt(a.x() * a.x() + a.y() * a.y()));
    return around(pose.position, s.half_length * a.cwiseAbs() + s.radius * rim);
  }
  Aabb operator()(const HalfSpace&) const {
    return {Vec3::Constant(-infinity), Vec3::Constant(infinity)};
  }
  Aabb operator()(const ConvexHull& s) const {
    const Mat3 rotation = pose.orientation.toRotationMatrix();
    Vec3 lower = Vec3::Constant(infinity), upper = Vec3::Constant(-infinity);
    for (const Vec3& vertex : s.data->vertices) {
      const Vec3 p = rotation * vertex;
      lower = lower.cwiseMin(p);
      upper = upper.cwiseMax(p);
    }
    return {pose.position + lower, pose.position + upper};
  }
  Aabb operator()(const TriangleMesh& s) const {
    const Mat3 rotation = pose.orientation.toRotationMatrix();
    Vec3 lower = Vec3::Constant(infinity), upper = Vec3::Constant(-infinity);
    for (const Vec3& vertex : s.data->vertices) {
      const Vec3 p = rotation * vertex;
      lower = lower.cwiseMin(p);
      upper = upper.cwiseMax(p);
    }
    return {pose.position + lower, pose.position + upper};
  }
  Aabb operator()(const HeightField& s) const {
    Aabb box = s.data->bounds();
    box.lower.z() -= s.data->size;  // solid below
    const Mat3 rotation = pose.orientation.toRotationMatrix();
    return around(pose.apply(0.5 * (box.lower + box.upper)),
                  rotation.cwiseAbs() * (0.5 * (box.upper - box.lower)));
  }
  Aabb operator()(const Compound& s) const {
    Aabb box{Vec3::Constant(infinity), Vec3::Constant(-infinity)};
    for (const CompoundPart& part : s.data->parts) {
      const Aabb inner = bounding_box(part.shape, pose * part.pose);
      box.lower = box.lower.cwiseMin(inner.lower);
      box.upper = box.upper.cwiseMax(inner.upper);
    }
    return box;
  }
};

struct BoundingRadius {
  const Vec3& center;

  double operator()(const Particle&) const { return center.norm(); }
  double operator()(const Sphere& s) const { return center.norm() + s.radius; }
  double operator()(const Box& s) const { return (center.cwiseAbs() + s.half_extents).norm(); }
  double operator()(const Capsule& s) const {
    const Vec3 to_end(center.x(), center.y(), std::abs(center.z()) + s.half_length);
    return to_end.norm() + s.radius;
  }
  double operator()(const Cylinder& s) const {
    const double across = center.head<2>().norm() + s.radius;
    const double along = std::abs(center.z()) + s.half_length;
    return std::sqrt(across * across + along * along);
  }
  double operator()(const HalfSpace&) const { return infinity; }
  double operator()(const ConvexHull& s) const {
    double radius_sq = 0.0;
    for (const Vec3& vertex : s.data->vertices) {
      radius_sq = std::max(radius_sq, (vertex - center).squaredNorm());
    }
    return std::sqrt(radius_sq);
  }
  double operator()(const TriangleMesh& s) const {
    double radius_sq = 0.0;
    for (const Vec3& vertex : s.data->vertices) {
      radius_sq = std::max(radius_sq, (vertex - center).squaredNorm());
    }
    return std::sqrt(radius_sq);
  }
  double operator()(const HeightField& s) const {
    const Aabb box = s.data->bounds();
    return (0.5 * (box.upper - box.lower) + (0.5 * (box.lower + box.upper) - center).cwiseAbs())
        .norm();
  }
  double operator()(const Compound& s) const {
    double radius = 0.0;
    for (const CompoundPart& part : s.data->parts) {
      radius = std::max(radius, bounding_radius(part.shape, part.pose.apply_inverse(center)));
    }
    return radius;
  }
};

}  // namespace

Aabb bounding_box(const Shape& shape, const Pose& pose) {
  return std::visit(BoundingBox{pose}, shape);
}

double bounding_radius(const Shape& shape, const Vec3& center) {
  return std::visit(BoundingRadius{center}, shape);
}

}  // namespace rb
