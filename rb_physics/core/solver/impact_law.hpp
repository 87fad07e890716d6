// The impact laws (S11-S14): one problem in, one result out.
//
//   SEQUENTIAL    one contact after the other, in index order, until none approaches (S12)
//   SIMULTANEOUS  all contacts at once: the notes' constrained least squares (S13, S14)
//   REFLECTIONS   generalised reflections of Smith, Kaufman, Vouga, Tamstorf & Grinspun 2012
//
// A law gives the normal impulses; with one contact all are S11's closed form. Friction follows
// with the law's normal impulses as bounds (impact_friction.hpp), so that no law gains energy by
// it.
#pragma once

#include <cstdint>

#include "contact/problem.hpp"
#include "solver/contact_solver.hpp"
#include "solver/impact_conditions.hpp"

namespace rb {

enum class ImpactLaw : std::uint8_t { SEQUENTIAL, SIMULTANEOUS, REFLECTIONS };

struct ImpactReport {
  double residual = 0.0;     // largest violation of the conditions of S14, relative
  double energy_gain = 0.0;  // kinetic energy gained, relative; 0 when none was
  int iterations = 0;        // collisions, passes or pivots of the law, and solver iterations
  bool capped = false;       // the law met its bound and ended with the inelastic answer
  ImpactConditions conditions;
};

// problem.velocity: before the impact (v-); bias: minus the velocity of immovable bodies.
// out.impulse: N s, contact frame; out.velocity: after the impact. Nothing approaching: v+ = v-.
ImpactReport apply_impact(const ContactProblem& problem, ImpactLaw law, ContactSolution& out,
                          SolverWorkspace& workspace);

}  // namespace rb
