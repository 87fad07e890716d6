// Where a point lies about one triangle of a mesh or height field.
#pragma once

#include "collision/surface_features.hpp"
#include "collision/triangle_prism.hpp"

namespace rb {

struct NearestOnTriangle {
  Vec3 point;
  PrismFeature feature;
};

// Point of a triangle nearest to p, by the Voronoi regions of its features (Ericson 2005, 5.1.5).
NearestOnTriangle nearest_on(const SurfaceTriangle& t, const Vec3& p);

// How far p lies outside the triangle's edge k, seen along the normal, m.
double outside(const SurfaceTriangle& t, int k, const Vec3& p);

// Does p project into the triangle? Beyond a concave edge the surface turns up: a point behind the
// neighbor as well belongs to both where, brought up to the neighbor's plane, it is over this one.
bool projects_into(const SurfaceTriangle& t, const Vec3& p, double tolerance);

}  // namespace rb
