// Interior-point method for the cone problem: a start for Newton where sweeps leave too much open.
//
// Follows the central path x o y = 2 gap e of the second-order cones with Nesterov-Todd scaling and
// Mehrotra's predictor and corrector; De Saxce's term mu |u_t| is renewed at every iteration. One
// factorisation an iteration, 10 to 20 iterations to 1e-5 whatever the size of the island, but the
// last digits come slowly (contacts that stick without force are degenerate): those are Newton's.
#pragma once

#include <vector>

#include "contact/problem.hpp"
#include "solver/body_space.hpp"
#include "solver/friction_cone.hpp"
#include "solver/residual.hpp"

namespace rb {

struct InteriorPointWorkspace {
  std::vector<Vec6> z, dz, rhs, v;
  std::vector<Vec3> x, y, dx, dy, shift, gap_of_slip, scaled, predicted;
  std::vector<Mat3> scaling, inverse_scaling;
  std::vector<ReactionDerivative> d;
  std::vector<Vec3> impulse;
};

struct InteriorPointReport {
  double residual = 0.0;  // natural map of the best iterate
  int steps = 0;
};

// Contacts without moments only. `impulse` out: the best iterate; in: unused. `space` must be
// prepared for this problem. Ends at `tolerance`, after `max_steps`, or when it cannot move.
InteriorPointReport interior_point(const ContactProblem& problem, const ContactScales& scales,
                                   const std::vector<FrictionCone>& cones, double tolerance,
                                   int max_steps, BodySpace& space, InteriorPointWorkspace& ws,
                                   std::vector<Vec3>& impulse);

}  // namespace rb
