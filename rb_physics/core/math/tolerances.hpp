// One home for every tolerance of the core: unit, effect, warning.
#pragma once

namespace rb::tolerance {

// Relative to the size of the bodies (m/m): |separation| <= touch * size counts as touching.
// Larger: contacts are reported before they carry force. Smaller: rounding makes them flicker.
inline constexpr double touch = 1e-9;

// m/s per (m/s of typical speed): |N . V| below it is RESTING (S9).
inline constexpr double resting_speed = 1e-9;

// Relative natural-map residual a direct island must reach; see solver/residual.hpp.
inline constexpr double direct_residual = 1e-13;

// Relative natural-map residual any island may report; above it the step says so.
inline constexpr double residual_ceiling = 1e-8;

// |q| may differ from 1 by this much at the interface and is then normalised; beyond it is an error.
inline constexpr double quaternion_norm = 1e-3;

// Relative violation of J1 + J2 >= J3 that is refused (equality is a legal lamina).
inline constexpr double inertia_triangle = 1e-9;

}  // namespace rb::tolerance
