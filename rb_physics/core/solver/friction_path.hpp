// For few contacts that jam, where Newton finds no way in: the answer without friction is easy to
// find, and is followed while all coefficients grow in one proportion to what they are.
#pragma once

#include <vector>

#include "contact/problem.hpp"
#include "solver/friction_cone.hpp"
#include "solver/residual.hpp"

namespace rb {

struct FrictionPathReport {
  int steps = 0;  // Newton steps, each with a dense factorisation
  bool arrived = false;
};

// Newton on the natural map (residual.hpp) with a line search: from the impulses and moments
// (empty: none) that are given, then, with steps left, along the path. They become the answer, or
// the nearest that was found on the way. Dense: the cost of a step grows with the cube of the
// number of contacts.
FrictionPathReport friction_path(const ContactProblem& problem, const ContactScales& scales,
                                 const std::vector<FrictionCone>& cones, int max_steps,
                                 std::vector<Vec3>& impulse, std::vector<Vec3>& moment);

}  // namespace rb
