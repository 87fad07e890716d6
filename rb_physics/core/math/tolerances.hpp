// One home for every tolerance of the core: unit, effect, warning.
#pragma once

namespace rb::tolerance {

// Relative to the size of the bodies (m/m): |separation| <= touch * size counts as touching.
// Larger: contacts are reported before they carry force. Smaller: rounding makes them flicker.
inline constexpr double touch = 1e-9;

// m/s per (m/s of typical speed): |N . V| below it is RESTING (S9).
inline constexpr double resting_speed = 1e-9;

// m/s: with Settings::sleeping, an island may sleep while no point of it moves faster. Larger: what
// creeps is stopped. Smaller: large heaps, solved less exactly, never sleep.
inline constexpr double sleep_speed = 1e-6;

// s an island must have been that slow before it sleeps.
inline constexpr double sleep_time = 0.5;

// Relative: contact and applied impulses of a body must balance this well before it sleeps, so that
// the wrenches published from then on are right.
inline constexpr double sleep_balance = 1e-6;

// Relative natural-map residual a direct island must reach; see solver/residual.hpp.
inline constexpr double direct_residual = 1e-13;

// Relative natural-map residual any island may report; above it the step says so.
inline constexpr double residual_ceiling = 1e-8;

// |q| may differ from 1 by this much at the interface and is then normalised; beyond it is an
// error.
inline constexpr double quaternion_norm = 1e-3;

// Relative violation of J1 + J2 >= J3 that is refused (equality is a legal lamina).
inline constexpr double inertia_triangle = 1e-9;

// Sine of the angle below which a face or edge counts as parallel to a face: it decides the kind of
// a contact and which points belong to it, never a position. Larger: a tilted face reads FACE_FACE.
inline constexpr double parallel = 1e-6;

// Relative to the smaller shape (m/m): features this close count as coincident (a corner on an
// edge), so that feature ids don't flicker with rounding. Larger: points move by this much.
inline constexpr double coincident = 1e-9;

// Relative to the smaller shape (m/m): a separating axis must beat an earlier one of the fixed
// order by this much. Larger: separations are off by this much. Smaller: the axis flickers.
inline constexpr double axis_preference = 1e-10;

// Two edges whose directions meet at a smaller sine have no separating axis of their own.
inline constexpr double parallel_edges = 1e-7;

// Relative to the smaller shape (m/m): shapes closer than this have no reliable direction of the
// shortest connection; the separating axis of the features is used instead.
inline constexpr double closest_direction = 1e-7;

}  // namespace rb::tolerance
