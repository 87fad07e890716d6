// The contact solver: one call per island, staged.
//
//   1 warm start checked: done if it solves the problem with minimum norm
//     contacts without friction: pivoting on the normals alone, and done    (frictionless)
//   2 a few block Gauss-Seidel sweeps                      (block_gauss_seidel)
//   3 proximal Newton to rounding, if the factorisation is affordable    (cone_newton)
//     otherwise accelerated iterations, residual as reached; a jam of few contacts where Newton
//     circles follows the answer from no friction to all of it    (friction_path)
//   4 contacts that slip against a larger static coefficient get the kinetic one: again from 3
//   5 where contacts slide, the answer their order has no part in    (sliding_load)
//   6 least impulses among those that solve the problem    (minimum_norm)
//   7 judged by the residual
#pragma once

#include <algorithm>
#include <vector>

#include "contact/problem.hpp"
#include "solver/block_gauss_seidel.hpp"
#include "solver/body_space.hpp"
#include "solver/cone_newton.hpp"
#include "solver/frictionless.hpp"
#include "solver/interior_point.hpp"
#include "solver/minimum_norm.hpp"
#include "solver/residual.hpp"
#include "solver/sliding_load.hpp"
#include "solver/solver_settings.hpp"
#include "solver/wide_contacts.hpp"

namespace rb {

// Memory that a later solve uses again. Holds no state: results never depend on it.
struct SolverWorkspace {
  std::vector<FrictionCone> cones;
  std::vector<std::uint8_t> kinetic;  // contacts that slipped against their static coefficient
  GaussSeidelWorkspace gauss_seidel;
  BodySpace space;
  FrictionlessWorkspace frictionless;
  ConeNewtonWorkspace newton;
  InteriorPointWorkspace interior_point;
  MinimumNormWorkspace minimum_norm;
  SlidingLoadWorkspace sliding_load;
  WideContacts wide;
  std::vector<Vec6> v;
  std::vector<Vec3> slips;  // of v, as it was last measured
  std::vector<Vec3> saved_impulse, saved_moment, best_impulse, best_moment, direction,
      moment_direction;
  // Of impulses f: f . u- before them, and f . A f, by which they change it.
  struct Power {
    double approach = 0.0, turned = 0.0;
    // Of all shares of the impulses the one that leaves the least energy; 1 where more would.
    double least_energy_share() const {
      return turned > 0.0 ? std::clamp(-approach / turned, 0.0, 1.0) : 1.0;
    }
  };
  std::vector<Power> powers;  // by block of contacts
  std::vector<Vec6> certificate;
  ContactScales scales;
};

// `io` in: warm start (impulse of size nc, or empty), certificate if known; out: the answer.
SolveReport solve_contacts(const ContactProblem& problem, const SolverSettings& settings,
                           ContactSolution& io, SolverWorkspace& workspace);

// Throws std::invalid_argument naming the contact and the field when the problem is malformed
// (index out of range, negative coefficient, a number that is not finite).
void check_problem(const ContactProblem& problem);

}  // namespace rb
