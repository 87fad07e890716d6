// A placed box as a polytope: corners, faces, support mapping, feature names.
#pragma once

#include <array>

#include "collision/face_polygon.hpp"
#include "collision/gjk.hpp"
#include "collision/manifold.hpp"
#include "shape/shape.hpp"

namespace rb {

// Vertex index: bit i is set where coordinate i is positive.
inline Vec3 box_corner(const Box& box, int index) {
  const Vec3& h = box.half_extents;
  return {index & 1 ? h.x() : -h.x(), index & 2 ? h.y() : -h.y(), index & 4 ? h.z() : -h.z()};
}

// Edge along `axis` through the corner with these sign bits.
inline int box_edge_index(int axis, int corner) {
  return 4 * axis + ((corner >> ((axis + 1) % 3)) & 1) + 2 * ((corner >> ((axis + 2) % 3)) & 1);
}

// Corners of face `2 * axis + positive`, counterclockwise seen from outside.
inline FacePolygon box_face(const Box& box, const Placement& placement, int face,
                            std::array<PolygonCorner, 4>& corners) {
  const int axis = face / 2, j = (axis + 1) % 3, k = (axis + 2) % 3;
  const bool positive = face % 2 == 1;
  // Sign bits of (j, k) around the face; the other way round on the negative side.
  static constexpr int around[4] = {0, 1, 3, 2};
  FacePolygon polygon;
  int index[4];
  for (int i = 0; i < 4; ++i) {
    const int bits = around[positive ? i : 3 - i];
    index[i] = ((bits & 1) << j) | (((bits >> 1) & 1) << k) | (positive ? 1 << axis : 0);
    corners[i].point = placement.apply(box_corner(box, index[i]));
    corners[i].vertex = make_feature(FeatureType::VERTEX, index[i]);
  }
  for (int i = 0; i < 4; ++i) {
    const int changed = index[i] ^ index[(i + 1) % 4];
    const int along = changed == 1 ? 0 : changed == 2 ? 1 : 2;
    corners[i].edge = make_feature(FeatureType::EDGE, box_edge_index(along, index[i]));
  }
  polygon.normal =
      positive ? Vec3(placement.rotation.col(axis)) : Vec3(-placement.rotation.col(axis));
  polygon.face = make_feature(FeatureType::FACE, face);
  polygon.size = 4;
  polygon.corners = corners.data();
  return polygon;
}

struct BoxSupport {
  const Box& box;
  const Placement& placement;

  SupportPoint operator()(const Vec3& direction) const {
    const Vec3 d = placement.rotation.transpose() * direction;
    const int index = (d.x() > 0.0 ? 1 : 0) | (d.y() > 0.0 ? 2 : 0) | (d.z() > 0.0 ? 4 : 0);
    return {placement.apply(box_corner(box, index)), index};
  }
};

// The feature spanned by corners whose indices differ in these bits.
inline std::uint32_t box_feature(int corner, int free_bits) {
  switch (free_bits) {
    case 0:
      return make_feature(FeatureType::VERTEX, corner);
    case 1:
      return make_feature(FeatureType::EDGE, box_edge_index(0, corner));
    case 2:
      return make_feature(FeatureType::EDGE, box_edge_index(1, corner));
    case 4:
      return make_feature(FeatureType::EDGE, box_edge_index(2, corner));
    default:
      break;
  }
  const int axis = !(free_bits & 1) ? 0 : !(free_bits & 2) ? 1 : 2;
  return make_feature(FeatureType::FACE, 2 * axis + ((corner >> axis) & 1));
}

}  // namespace rb
