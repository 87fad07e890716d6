// Keeping the points of a manifold that carry the force.
#pragma once

#include <vector>

#include "collision/manifold.hpp"

namespace rb {

// Adds `points` (corners of a convex polygon in order, seen along `normal`) to `out`. More than
// eight are thinned: the deepest stays, then those that enclose the largest area.
void reduce(std::vector<ManifoldPoint>& points, const Vec3& normal, Manifold& out);

// The same for points in no order.
void reduce_cloud(std::vector<ManifoldPoint>& points, const Vec3& normal, Manifold& out);

// Splits points in no order by their normals (equal within `angle`, rad) and thins each group.
void reduce_by_normal(const std::vector<ManifoldPoint>& points, double angle,
                      std::vector<Manifold>& out);

}  // namespace rb
