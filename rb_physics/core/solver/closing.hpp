// The least displacement that closes contacts, from both sides: min |d|_M^2 / 2 with J_n d + s = 0.
// One factorisation; contacts that agree may be redundant.
#pragma once

#include <cstdint>
#include <vector>

#include "contact/problem.hpp"
#include "solver/body_space.hpp"

namespace rb {

struct ClosingWorkspace {
  std::vector<FrictionCone> cones;
  std::vector<ReactionDerivative> d;
  std::vector<Vec6> z, wrench, step;
};

// `problem`: bias (s, 0, 0) in m; `closed[i]`: contact i is to be closed, the others are left out.
// Fills `displacement` (m, rad; of size nb); false if that is too much to factorise. Contacts that
// contradict each other are closed in the mean: the gaps it leaves tell.
bool close_contacts(const ContactProblem& problem, const std::vector<std::uint8_t>& closed,
                    double max_work, BodySpace& space, ClosingWorkspace& ws,
                    std::vector<Vec6>& displacement);

}  // namespace rb
