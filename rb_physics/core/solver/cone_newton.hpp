// Proximal point + semismooth Newton in body velocities: converges to rounding.
//
// Outer:  lambda <- G(lambda - u/eps),  the proximal point (augmented Lagrangian) step, with
// inner:  z = B^T J^T G(lambda - u(z)/eps) solved by Newton for the scaled velocities z.
// G is either
//   Coulomb:     Alart & Curnier's map: Coulomb's law itself, unsymmetric Newton matrix, so that
//   many
//                contacts sliding at once converge quadratically; or
//   associated:  P_K with De Saxce's term s = mu |u_t| held fixed: a convex problem, symmetric,
//   every
//                Newton step descends; s is renewed between outer steps (crawls when much slides).
// eps > 0 keeps redundant contacts (singular Delassus matrix) regular without touching the limit.
#pragma once

#include <vector>

#include "contact/problem.hpp"
#include "solver/body_space.hpp"
#include "solver/friction_cone.hpp"
#include "solver/residual.hpp"

namespace rb {

struct ConeNewtonWorkspace {
  std::vector<Vec6> z, dz, gradient, wrench, v;
  std::vector<Reaction> anchor, reaction, argument, slip, slip_step;
  double zp = 0.0, pp = 0.0;
  std::vector<ReactionDerivative> d;
  std::vector<Vec3> best_impulse, best_moment;
};

struct ConeNewtonOptions {
  enum class Map { kCoulomb, kAssociated };
  Map map = Map::kCoulomb;
  double softness = 1e-5;        // eps relative to the smallest w_i
  double first_softness = 1e-1;  // of the first outer step, times hardening at each further one
  double good_start = 1e-5;      // a residual at or below it allows a stiff first step
  double hardening = 0.03;
  double inner_tolerance = 1e-6;
  int max_outer = 30;
  int max_steps = 100;
  int max_inner = 12;
  double tolerance = 1e-13;
  double enough = 0.0;  // at or below it, two outer steps of the same size end the work
  double plenty = 0.0;  // at or below it, the work ends
};

struct ConeNewtonReport {
  double residual = 0.0;
  int outer = 0;
  int steps = 0;
};

// `impulse`, `moment` in: start, out: the best iterate. space must be prepared for this problem.
ConeNewtonReport cone_newton(const ContactProblem& problem, const ContactScales& scales,
                             const std::vector<FrictionCone>& cones,
                             const ConeNewtonOptions& options, BodySpace& space,
                             ConeNewtonWorkspace& ws, std::vector<Vec3>& impulse,
                             std::vector<Vec3>& moment);

}  // namespace rb
