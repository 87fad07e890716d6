// Distance to a mesh or height field, and ways through it.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "collision/queries.hpp"
#include "collision/surface_data.hpp"
#include "collision/surface_features.hpp"
#include "collision/surface_triangle.hpp"
#include "collision/triangle_prism.hpp"

namespace rb {

void check_convex(const Shape& convex, const Shape& surface) {
  if (is_surface(convex) || std::holds_alternative<HalfSpace>(convex)) {
    throw std::invalid_argument(std::string("contacts between ") + shape_name(convex) + " and " +
                                shape_name(surface) + " are not available");
  }
}

bool is_inside(const Shape& surface, const Vec3& point) {
  const auto* mesh = std::get_if<TriangleMesh>(&surface);
  if (mesh != nullptr && !mesh->data->closed) return false;
  const std::optional<RayHit> hit = ray_cast(surface, Pose{}, point, Vec3::UnitZ());
  return hit && hit->normal.z() > 0.0;
}

SurfaceDistance surface_distance(const Shape& convex, const Pose& pose_convex, const Shape& surface,
                                 const Pose& pose_surface) {
  check_convex(convex, surface);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const Pose relative = pose_surface.inverse() * pose_convex;
  const Placement at{relative.orientation.toRotationMatrix(), relative.position};
  const Aabb box = bounding_box(convex, relative);
  const Vec3 center = center_of(convex, relative);
  SurfaceDistance best{infinity, {}};
  static thread_local TrianglePrism prism;
  with_data(surface, [&](const auto& data) {
    const Aabb all = surface_bounds(data);
    // Look ever farther until what was found is nearer than anything not looked at.
    double reach = characteristic_size(convex);
    for (bool complete = false; !complete && best.distance > reach; reach *= 8.0) {
      Aabb near = box;
      near.lower.array() -= reach;
      near.upper.array() += reach;
      complete = (near.lower.array() <= all.lower.array()).all() &&
                 (near.upper.array() >= all.upper.array()).all();
      best.distance = infinity;
      data.for_each_triangle(near, [&](std::int32_t index) {
        SurfaceTriangle t = data.triangle(index);
        if (is_sheet(data) && t.normal.dot(center - t.corner[0]) < 0.0) t = turned_over(t);
        Manifold manifold;
        leaf_contacts(convex, at, prism.place(t, thin(t)), Placement{}, best.distance, manifold);
        for (int i = 0; i < manifold.size(); ++i) {
          if (manifold[i].separation < best.distance) {
            best = {manifold[i].separation, manifold[i]};
          }
        }
      });
    }
  });
  if (best.distance > 0.0 && is_inside(surface, center)) best.distance = 0.0;
  const Mat3 rotation = pose_surface.orientation.toRotationMatrix();
  best.nearest.point_a = rotation * best.nearest.point_a + pose_surface.position;
  best.nearest.point_b = rotation * best.nearest.point_b + pose_surface.position;
  best.nearest.normal = rotation * best.nearest.normal;
  return best;
}

std::optional<double> surface_crossing(const Shape& convex, const Shape& surface, const Vec3& from,
                                       const Vec3& to) {
  std::optional<double> first;
  with_data(surface, [&](const auto& data) {
    const double depth = slack(data), rounding = 1e-9 * data.size;
    const bool both_sides = is_sheet(data) && !std::holds_alternative<Particle>(convex);
    const Aabb way{from.cwiseMin(to).array() - depth, from.cwiseMax(to).array() + depth};
    data.for_each_triangle(way, [&](std::int32_t index) {
      const SurfaceTriangle t = data.triangle(index);
      double before = t.normal.dot(from - t.corner[0]), after = t.normal.dot(to - t.corner[0]);
      if (both_sides && before < 0.0) before = -before, after = -after;
      if (!(before >= -rounding && after < -depth)) return;
      const double share = std::max(before, 0.0) / (std::max(before, 0.0) - after);
      const Vec3 crossing = from + share * (to - from);
      for (int k = 0; k < 3; ++k) {
        // From just behind one slope of a valley through the other.
        const double beside = t.edge[k] == EdgeType::CONCAVE ? 2.0 * depth : rounding;
        if (outside(t, k, crossing) > beside) return;
      }
      if (!first || share < *first) first = share;
    });
  });
  return first;
}

bool meets_surface(const Shape& convex, const Pose& pose_convex, const Shape& surface,
                   const Pose& pose_surface) {
  return surface_distance(convex, pose_convex, surface, pose_surface).distance <= 0.0;
}

}  // namespace rb
