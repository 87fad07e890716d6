// The least displacement that separates: min |d|_M^2 / 2 with J_n d + s >= 0, normals only. By wide
// accelerated sweeps; d is unique, the impulses (kg m) behind it are not asked for.
#pragma once

#include <vector>

#include "contact/problem.hpp"
#include "solver/wide_contacts.hpp"

namespace rb {

struct SeparationReport {
  int sweeps = 0;
  double left = 0.0;  // m, greatest gap that is still missing
};

// What `wide` has loaded must be the same problem but for the numbers below, or forgotten.
// `problem`: velocity zero, coefficients zero, bias (s, 0, 0) in m. Ends when no gap is missing by
// more than `slack`, or after `most_sweeps`.
SeparationReport separate_bodies(const ContactProblem& problem, double slack, int most_sweeps,
                                 WideContacts& wide, std::vector<Vec6>& displacement);

}  // namespace rb
