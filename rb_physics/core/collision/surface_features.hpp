// Which features of a triangulated surface can be touched, and with which normals.
#pragma once

#include <cmath>

#include "collision/triangle_prism.hpp"
#include "shape/height_field.hpp"
#include "shape/hull.hpp"
#include "shape/mesh.hpp"
#include "shape/triangle.hpp"

namespace rb {

// A convex edge: normals between those of its two faces; the surface's end: on the outer side of
// its one face; flat and concave edges: none.
inline bool edge_admits(const SurfaceTriangle& t, int k, const Vec3& normal) {
  if (t.edge[k] == EdgeType::FLAT || t.edge[k] == EdgeType::CONCAVE) return false;
  const Vec3 e = (t.corner[(k + 1) % 3] - t.corner[k]).normalized();
  if (normal.dot(e.cross(t.normal)) < -flat_angle) return false;
  return t.edge[k] == EdgeType::BOUNDARY ? normal.dot(t.normal) >= 0.0
                                         : normal.dot(t.neighbor_normal[k].cross(e)) >= -flat_angle;
}

template <class Data>
bool corner_admits(const Data& data, const SurfaceTriangle& t, int k, const Vec3& normal) {
  return normal.dot(t.normal) > 0.0 && data.vertex_admits(t.corner_id[k], normal);
}

// For the edges and corners of the triangle and its front; sides and back of a prism: never.
template <class Data>
bool admits(const Data& data, const SurfaceTriangle& t, const PrismFeature& f, const Vec3& normal) {
  switch (f.kind) {
    case PrismFeature::EDGE:
      return edge_admits(t, f.index, normal);
    case PrismFeature::CORNER:
      return corner_admits(data, t, f.index, normal);
    case PrismFeature::FACE:
      return normal.dot(t.normal) > 0.0;
    case PrismFeature::NONE:
      break;
  }
  return false;
}

// An open mesh has two sides; a closed one and a height field are solid behind.
inline bool is_sheet(const MeshData& mesh) { return !mesh.closed; }
inline bool is_sheet(const HeightData&) { return false; }

// A point well inside of the shape.
inline Vec3 center_of(const Shape& shape, const Pose& pose) {
  const auto* hull = std::get_if<ConvexHull>(&shape);
  return hull != nullptr ? pose.apply(hull->data->center) : pose.position;
}

// m, thickness that stands for none: a prism has to have a volume.
inline double thin(const SurfaceTriangle& t) {
  return 1e-6 * std::sqrt((t.corner[1] - t.corner[0]).cross(t.corner[2] - t.corner[0]).norm());
}

}  // namespace rb
