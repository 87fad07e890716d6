// Contact points of a cylinder once the normal is known.
#pragma once

#include <algorithm>
#include <vector>

#include "collision/cylinder_features.hpp"
#include "collision/planar_region.hpp"

namespace rb {

// The cylinder is A, the region belongs to B, and the region's normal is the contact normal: cap on
// face, side line on face, or rim on face. Appends to `points`, whatever their number.
void cylinder_on_region(const PlacedCylinder& a, const PlanarRegion& region, double margin,
                        double tolerance, std::vector<ManifoldPoint>& points);

// The corners and edges of a polygon of B under the cap of A. The contact normal is the cap's
// (reversed) or, where the two lie flat on each other, the polygon's.
enum class CapNormal { OF_CAP, OF_POLYGON };
void polygon_on_cap(const PlacedCylinder& a, bool upper, const FacePolygon& polygon,
                    CapNormal normal, double margin, double tolerance,
                    std::vector<ManifoldPoint>& points);

// The part of a segment center + t * along, |t| <= half, that lies beside a nearly parallel
// cylinder.
struct SideOverlap {
  Vec3 normal;           // unit, across the cylinder's axis, toward the segment
  double t[2];           // m, the upper end and the lower
  bool of_cylinder[2];   // the cylinder ends there, not the segment
  double separation[2];  // m, from the side
};
// Are the ends of the overlap where the shapes are nearest? `proven` (m): the separation along its
// normal; `nearest` (m): along the best axis.
inline bool carries(const SideOverlap& side, double proven, double nearest, double tolerance) {
  return !(proven < nearest - tolerance) &&
         !(std::min(side.separation[0], side.separation[1]) > nearest + tolerance);
}

// `direction`: about the normal. False: they are not parallel, or not side by side.
bool side_overlap(const PlacedCylinder& cylinder, const Vec3& direction, const Vec3& center,
                  const Vec3& along, double half, double tolerance, SideOverlap& found);

// Whether a cap and a face lean so little that the rest of the overlap is next to touch.
inline bool nearly_flat(const Vec3& cap_normal, const Vec3& face_normal) {
  constexpr double nearly = 0.98;  // cosine
  return -cap_normal.dot(face_normal) >= nearly;
}

// Adds those of `more` that are neither deeper than what is in `points` nor there already, at the
// same place or of the same features.
void add_shallower(const std::vector<ManifoldPoint>& more, double tolerance,
                   std::vector<ManifoldPoint>& points);

// m; infinite when there are none.
double least_separation(const std::vector<ManifoldPoint>& points);

// Exchanges A and B in place.
void mirror(std::vector<ManifoldPoint>& points);

}  // namespace rb
