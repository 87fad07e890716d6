// What the queries of a mesh or height field share: its triangles, whichever it is, and its inside.
#pragma once

#include "collision/surface_contacts.hpp"
#include "shape/height_field.hpp"
#include "shape/mesh.hpp"

namespace rb {

template <class Visit>
decltype(auto) with_data(const Shape& surface, Visit&& visit) {
  if (const auto* mesh = std::get_if<TriangleMesh>(&surface)) return visit(*mesh->data);
  return visit(*std::get<HeightField>(surface).data);
}

// std::invalid_argument where the first of the two is not convex, or has no end.
void check_convex(const Shape& convex, const Shape& surface);

// Is the point (surface coordinates) inside of a closed mesh or below a height field? Then the
// first triangle straight above is seen from behind.
bool is_inside(const Shape& surface, const Vec3& point);

inline Aabb surface_bounds(const MeshData& mesh) { return mesh.bvh.bounds(); }
inline Aabb surface_bounds(const HeightData& field) { return field.bounds(); }

// m: how far behind a face a particle may be that has just met it.
template <class Data>
double slack(const Data& data) {
  return 1e-6 * data.size;
}

}  // namespace rb
