// Mass properties of a solid bounded by triangles.
#pragma once

#include <array>
#include <vector>

#include "math/mass_properties.hpp"

namespace rb {

// Density 1 kg/m^3; triangles counterclockwise seen from outside, closed. Sums the moments of the
// tetrahedra that the triangles span with an inner point: the volume integrals of Mirtich 1996.
MassProperties polyhedron_mass(const std::vector<Vec3>& vertices,
                               const std::vector<std::array<int, 3>>& triangles);

}  // namespace rb
