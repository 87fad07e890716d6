// Contacts of a convex shape with a surface of triangles (mesh, height field), without bumps at its
// inner edges.
//
// A point of the shape touches a triangle's face with the face's own normal when it projects into
// the triangle: the manifold is that of the triangle's plane, cut to the triangle. So a box on a
// flat mesh has its four corners, each over one triangle, exactly as on a half-space. An edge or
// vertex of the surface touches only where the surface is convex (or ends) and only with a normal
// between those of its faces: the feature's Voronoi region. Flat and concave edges never touch.
//
// A closed mesh or a height field is solid behind. A shape whose centre is behind a triangle
// doesn't touch it (a ball: by more than its radius). One whose centre is inside, and that touches
// nothing else, is pushed out at the nearest point. An open mesh is a sheet: a shape touches it on
// the side on which its centre is; a particle, which has no side while it lies on it, on the front
// only.
#pragma once

#include <optional>
#include <vector>

#include "collision/leaf_contacts.hpp"
#include "collision/manifold.hpp"
#include "collision/queries.hpp"
#include "shape/shape.hpp"

namespace rb {

inline bool is_surface(const Shape& shape) {
  return std::holds_alternative<TriangleMesh>(shape) || std::holds_alternative<HeightField>(shape);
}

// Replaces `out` by the manifolds, one per normal, of the convex shape (A) with the surface (B).
void surface_contacts(const Shape& convex, const Pose& pose_convex, const Shape& surface,
                      const Pose& pose_surface, double margin, std::vector<Manifold>& out);

// The nearest triangle. 0 or less: the shapes meet, or the convex one is inside of a closed mesh or
// below a height field, and the contacts tell how deep.
struct SurfaceDistance {
  double distance;
  ManifoldPoint nearest;  // A convex, B surface
};
SurfaceDistance surface_distance(const Shape& convex, const Pose& pose_convex, const Shape& surface,
                                 const Pose& pose_surface);

// Does the shape meet a triangle, or lie inside a closed mesh or below a height field?
bool meets_surface(const Shape& convex, const Pose& pose_convex, const Shape& surface,
                   const Pose& pose_surface);

// The share of the straight way from one point to another (m, surface coordinates), those of a
// shape's middle, at which it goes through the surface: from the front to the back, or through an
// open mesh from either side (a particle from the front). Nothing where it goes through none.
std::optional<double> surface_crossing(const Shape& convex, const Shape& surface, const Vec3& from,
                                       const Vec3& to);

// Contact time of a convex shape with a surface, whose inner edges are no obstacles
// (collision/queries.hpp).
ImpactSearch surface_time_of_impact(const Shape& convex, const Sweep& motion_convex,
                                    const Shape& surface, const Sweep& motion_surface, double t_max,
                                    int most_queries);

}  // namespace rb
