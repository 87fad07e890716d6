// Contact points of a cylinder once the normal is known.
#pragma once

#include <vector>

#include "collision/cylinder_features.hpp"
#include "collision/planar_region.hpp"

namespace rb {

// The cylinder is A, the region belongs to B, and the region's normal is the contact normal: cap on
// face, side line on face, or rim on face. Appends to `points`, whatever their number.
void cylinder_on_region(const PlacedCylinder& a, const PlanarRegion& region, double margin,
                        double tolerance, std::vector<ManifoldPoint>& points);

// The corners and edges of a polygon of B under the cap of A, where the cap's normal is the contact
// normal (reversed).
void polygon_on_cap(const PlacedCylinder& a, bool upper, const FacePolygon& polygon, double margin,
                    double tolerance, std::vector<ManifoldPoint>& points);

// Exchanges A and B in place.
void mirror(std::vector<ManifoldPoint>& points);

}  // namespace rb
