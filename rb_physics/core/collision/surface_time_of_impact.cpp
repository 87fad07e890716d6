// Contact time of a convex shape with a mesh or height field: the earliest over the triangles in
// its way.
#include <algorithm>
#include <cmath>

#include "collision/extent.hpp"
#include "collision/surface_contacts.hpp"
#include "collision/surface_features.hpp"
#include "collision/sweep.hpp"
#include "collision/triangle_prism.hpp"
#include "shape/height_field.hpp"
#include "shape/mesh.hpp"

namespace rb {
namespace {

// Surface coordinates that hold the shape during the whole motion.
Aabb swept_box(const Shape& convex, const Sweep& motion_convex, const Sweep& motion_surface,
               double t_max) {
  const Pose surface = motion_surface.at(0.0), start = motion_convex.at(0.0);
  const Vec3 from = surface.apply_inverse(motion_convex.center(0.0));
  const Vec3 to = motion_surface.at(t_max).apply_inverse(motion_convex.center(t_max));
  const double radius = bounding_radius(convex, start.apply_inverse(motion_convex.center(0.0)));
  // How far the path may leave the chord: a quarter of the speed bound, or by acceleration.
  const double bow =
      0.125 * t_max * t_max * (motion_convex.acceleration() - motion_surface.acceleration()).norm();
  double room = radius + bow;
  const double turn = motion_surface.max_angular_speed() * t_max;
  if (turn > 0.0) {  // a turning surface: hold everything it may sweep over
    room += turn * ((motion_convex.center(0.0) - motion_surface.center(0.0)).norm() +
                    t_max * max_relative_speed(motion_convex, motion_surface, 0.0, t_max));
  }
  return {from.cwiseMin(to).array() - room, from.cwiseMax(to).array() + room};
}

// Is the contact of the shape with this triangle one the surface would report? At inner edges it
// isn't; and a shape that comes sliding over an inner edge meets the next face without sinking into
// it.
template <class Data>
bool is_impact(const Data& data, const SurfaceTriangle& t, const Shape& convex, const Pose& pose,
               const Pose& later, const Shape& solid, const TrianglePrism& prism, double size) {
  Manifold manifold;
  leaf_contacts(convex, {pose.orientation.toRotationMatrix(), pose.position}, solid, Placement{},
                1e-7 * size, manifold);
  const bool sinks =
      extent(convex, later, -t.normal) > extent(convex, pose, -t.normal) + 1e-13 * size;
  for (int i = 0; i < manifold.size(); ++i) {
    const PrismFeature feature = prism.feature(manifold[i].feature_b);
    const bool along_face = manifold[i].normal.dot(t.normal) > 1.0 - flat_angle;
    if (admits(data, t, feature, manifold[i].normal) && (!along_face || sinks)) return true;
  }
  return manifold.size() == 0;  // can't tell: better one stop too many
}

template <class Data>
ImpactSearch search(const Data& data, const Shape& convex, const Sweep& motion_convex,
                    const Sweep& motion_surface, double t_max, int most_queries) {
  constexpr int max_false_impacts = 16;
  ImpactSearch best;
  const double size = characteristic_size(convex);
  std::vector<SurfaceTriangle> triangles;
  data.for_each_triangle(swept_box(convex, motion_convex, motion_surface, t_max),
                         [&](std::int32_t i) { triangles.push_back(data.triangle(i)); });
  std::sort(
      triangles.begin(), triangles.end(),
      [](const SurfaceTriangle& a, const SurfaceTriangle& b) { return a.face_id < b.face_id; });
  TrianglePrism prism;
  // All triangles share the queries; each may use some, so that those not yet looked at stay known.
  constexpr int least_queries = 20;
  for (const SurfaceTriangle& t : triangles) {
    const Shape& solid = prism.place(t, thin(t));
    double start = 0.0;
    for (int i = 0;; ++i) {
      const double end = best.time.value_or(t_max);
      const LaterSweep shape_rest(motion_convex, start), surface_rest(motion_surface, start);
      const ImpactSearch found =
          find_time_of_impact(convex, shape_rest, solid, surface_rest, end - start,
                              std::max(most_queries - best.iterations, least_queries));
      best.iterations += found.iterations;
      if (!found.time) break;
      const double time = start + *found.time;
      const double soon = std::min(time + 1e-4 * t_max, t_max);
      const Pose relative = motion_surface.at(time).inverse() * motion_convex.at(time);
      const Pose later = motion_surface.at(soon).inverse() * motion_convex.at(soon);
      if (i >= max_false_impacts || !found.converged ||
          is_impact(data, t, convex, relative, later, solid, prism, size)) {
        best.time = time;
        best.converged = found.converged;
        break;
      }
      // Past an inner edge: look on a little later.
      start = time + std::max(1e-3 * (end - time), 1e-12 * t_max);
      if (start >= end) break;
    }
  }
  return best;
}

}  // namespace

ImpactSearch surface_time_of_impact(const Shape& convex, const Sweep& motion_convex,
                                    const Shape& surface, const Sweep& motion_surface, double t_max,
                                    int most_queries) {
  if (const auto* mesh = std::get_if<TriangleMesh>(&surface)) {
    return search(*mesh->data, convex, motion_convex, motion_surface, t_max, most_queries);
  }
  return search(*std::get<HeightField>(surface).data, convex, motion_convex, motion_surface, t_max,
                most_queries);
}

}  // namespace rb
