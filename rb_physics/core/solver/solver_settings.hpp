// What a solver is asked to reach and how much it may work; what it reports.
#pragma once

#include <cstdint>

#include "math/tolerances.hpp"

namespace rb {

struct SolverSettings {
  double tolerance = tolerance::direct_residual;  // relative natural-map residual to reach
  double warm_tolerance = 1e-12;  // a warm start at or below it, with minimum norm, is the answer
  double warm_speed = 1e300;      // m/s, and this is the most it may leave at a contact
  double newton_goal = 1e-14;     // where the first Newton attempt ends, if rounding allows
  bool minimum_norm = true;       // of all impulses that solve the problem, find the least
  // Bound on the work of one solve in units of one sweep over one contact (about 0.1 us); 0: none.
  // When it bites, the result says so (converged = false, the residual reached).
  std::int64_t max_work = 0;
  // After two attempts a residual at or below it ends the work, whatever the tolerance: what is
  // left then is nearly always the rounding of an ill-conditioned island.
  double enough = 1e-10;
  int newton_attempts = 16;  // sweeps between the first, other starts, ever more sweeps
  // Largest direct factorisation (multiply-adds, one Newton step); islands above it iterate.
  double max_factor_work = 3e6;
  int max_sweeps = 60;  // for islands that iterate
};

struct SolveReport {
  double residual = 0.0;          // natural map, relative (residual.hpp)
  double start_residual = 0.0;    // that of the warm start
  double typical_velocity = 0.0;  // m/s, what it was relative to
  int sweeps = 0;                 // Gauss-Seidel sweeps or iterations of the accelerated method
  int newton_steps = 0;
  int factorizations = 0;
  bool converged = false;     // residual <= tolerance (or the rounding floor of the problem)
  bool minimum_norm = false;  // impulses certified as the least of all solutions
  bool warm_accepted = false;
  bool work_exhausted = false;  // max_work ended the solve
};

}  // namespace rb
