// Resting contact (S16): forces g >= 0 that keep d_dd >= 0 with g . d_dd = 0, from d_dd = A g + b.
//
// The contact problem is read in accelerations: problem.velocity holds the accelerations that all
// other forces cause (m/s^2, rad/s^2), and the normal part of bias the terms of d_dd that
// velocities cause (2 N_dot . ..., N_ddot . ..., r x w x w). Friction coefficients are not looked
// at.
#pragma once

#include "contact/problem.hpp"
#include "solver/lcp.hpp"

namespace rb {

enum class LcpMethod { LEMKE, PIVOTING };

struct RestingContact {
  Eigen::VectorXd force;           // g along N, N, size nc
  std::vector<Vec6> acceleration;  // of all bodies, m/s^2 and rad/s^2
  LcpResult lcp;
};

RestingContact resting_contact(const ContactProblem& accelerations, LcpMethod method);

}  // namespace rb
