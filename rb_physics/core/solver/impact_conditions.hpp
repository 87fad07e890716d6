// The four conditions on an impact (S14), checked after every solve.
#pragma once

#include <vector>

#include "contact/problem.hpp"

namespace rb {

struct ImpactConditions {
  // 1 Instantaneous: positions are not touched by a law; holds by construction.
  double attraction = 0.0;   // 2 repulsive, f >= 0: largest -f_i / max f
  double penetration = 0.0;  // 3 no interpenetration, d_dot+ >= 0: largest -d_dot_i+ / max |u-|
  double energy_gain = 0.0;  // 4 no gain: max(0, f . (A f + 2 d_dot-)) / (f . A f), all components
  double cone = 0.0;         // beyond: largest excess of |f_t| over mu f_n, / max f

  double worst() const;
};

// `impulse` and the velocities after it, problem.velocity before. With friction, f and d_dot stand
// for all components; velocities of kinematic bodies are in the bias, so that theirs is the frame
// in which no energy is gained.
ImpactConditions impact_conditions(const ContactProblem& problem, const std::vector<Vec3>& impulse,
                                   const std::vector<Vec3>& moment, const std::vector<Vec6>& after);

}  // namespace rb
