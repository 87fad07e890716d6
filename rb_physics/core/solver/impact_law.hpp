// The impact laws (S11-S14): one problem in, one result out; see apply_impact.
#pragma once

#include <cstdint>

#include "contact/problem.hpp"
#include "solver/contact_solver.hpp"

namespace rb {

enum class ImpactLaw : std::uint8_t { SEQUENTIAL, SIMULTANEOUS, REFLECTIONS };

struct ImpactReport {
  double residual = 0.0;     // relative, of the law's own conditions
  double energy_gain = 0.0;  // kinetic energy gained, relative; 0 when none was
  int iterations = 0;
};

// problem.velocity: before the impact (v-). out.impulse: N s, contact frame; out.velocity: after
// it.
ImpactReport apply_impact(const ContactProblem& problem, ImpactLaw law, ContactSolution& out,
                          SolverWorkspace& workspace);

}  // namespace rb
