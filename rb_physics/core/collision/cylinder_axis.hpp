// The direction along which a cylinder and another convex shape are farthest apart or overlap
// least, found feature against feature: caps and faces (flat), the side across an edge, a rim along
// an edge, a corner. Every answer is a proven separation; the greatest is the distance, or minus
// the penetration depth.
#pragma once

#include <limits>

#include "collision/cylinder_features.hpp"
#include "math/types.hpp"

namespace rb {

struct CylinderAxis {
  enum Kind { NONE, CAP, FACE, CROSSING, RIM, CORNER };
  Kind kind = NONE;
  double separation = -std::numeric_limits<double>::infinity();  // m
  Vec3 normal = Vec3::UnitZ();                                   // unit, toward the cylinder
  int feature = -1;  // of the other shape: face, edge or vertex; CAP: 0 the upper, 1 the lower
  Vec3 on_cylinder = Vec3::Zero();  // m, of CROSSING, RIM and CORNER: where the two meet
  Vec3 on_other = Vec3::Zero();     // m
};

// An edge of the other shape, with `radius` (m) of material around it.
struct AxisEdge {
  Vec3 tail;      // m
  Vec3 along;     // unit
  double length;  // m
  double radius;  // m
  int feature;
};

class CylinderAxisSearch {
 public:
  // `preference` (m): by how much another kind of axis must beat a cap or a face. `tolerance` (m):
  // how far beside each other features may pass and still meet.
  CylinderAxisSearch(const PlacedCylinder& cylinder, double preference, double tolerance)
      : cylinder_(cylinder), preference_(preference), tolerance_(tolerance) {}

  // A face of the other shape; or a cap, for which `separation` is measured to the other shape.
  void offer_flat(CylinderAxis::Kind kind, const Vec3& normal, double separation, int feature);
  // The side across an edge, for normals between those of the faces left and right of the edge.
  void offer_crossing(const AxisEdge& edge, const Vec3& left, const Vec3& right);
  void offer_crossing(const AxisEdge& edge, const Vec3& normal);
  // A rim along an edge, likewise.
  void offer_rim(const AxisEdge& edge, const Vec3& left, const Vec3& right);
  // All normals across an edge that no faces bound: the axis of a capsule or cylinder.
  void offer_free_edge(const AxisEdge& edge);
  // Side or rim at a corner. reach(n): the greatest n . x over the other shape (m).
  template <class Reach>
  void offer_corner(const Vec3& corner, int feature, const Reach& reach) {
    CylinderAxis axis;
    if (!at_corner(corner, axis) || !(axis.separation > free_.separation)) return;
    if (reach(axis.normal) > axis.normal.dot(corner) + 1e-3 * tolerance_) return;
    axis.feature = feature;
    free_ = axis;
  }

  // Would an axis of at most this separation (m) change nothing?
  bool useless(double bound) const {
    return bound <= std::max(free_.separation, flat_.separation - preference_);
  }

  // The greatest cap or face, the greatest of the others.
  const CylinderAxis& flat() const { return flat_; }
  const CylinderAxis& free() const { return free_; }
  bool prefers_flat() const { return flat_.separation >= free_.separation - preference_; }
  const CylinderAxis& best() const { return prefers_flat() ? flat_ : free_; }

 private:
  bool at_corner(const Vec3& corner, CylinderAxis& axis) const;
  void offer_beside(const AxisEdge& edge);
  void climb_rim(const AxisEdge& edge, const Vec3& low, const Vec3& high);
  void offer_rim_point(const AxisEdge& edge, const Vec3& on_rim, const Vec3& n);
  const PlacedCylinder& cylinder_;
  double preference_, tolerance_;
  CylinderAxis flat_, free_;
};

}  // namespace rb
