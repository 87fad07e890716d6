// Friction of an impact: Coulomb's true cone on the normal impulses that the law gave.
//
//   minimise kinetic energy over the tangential impulses (and moments) with |f_t,i| <= mu_i f_n,i
//
// so that each is opposite to the slip it leaves, or stops it, and energy can only fall. Where
// friction turns bodies into each other (Kane's paradox, Painleve's rod) the approach that is left
// ends in an inelastic impact with friction, which loses energy too.
#pragma once

#include <vector>

#include "contact/problem.hpp"
#include "solver/contact_solver.hpp"

namespace rb {

// `impulse` in: normal impulses of the law; out: with friction. v in: after the law; out: after
// all. Returns iterations.
int impact_friction(const ContactProblem& problem, std::vector<Vec3>& impulse,
                    std::vector<Vec3>& moment, std::vector<Vec6>& v, SolverWorkspace& workspace);

}  // namespace rb
