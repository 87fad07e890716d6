// A large island over a whole step: impacts, rest and friction in one solve (Moreau), in which
// every gap within reach is a constraint; bodies move with the velocities it ends at. What that
// solve left open of the gaps is put right by the least displacement, which no momentum sees.
#include <algorithm>
#include <cmath>

#include "math/tolerances.hpp"
#include "solver/contact_operators.hpp"
#include "solver/separation.hpp"
#include "world/advance.hpp"
#include "world/correct.hpp"

namespace rb {

void IslandAdvance::run_in_one_solve(double h) {
  find_partners();
  if (rebounds()) strike();
  carry(h, true);
  mark();
  book();
  shift_.clear();
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const Body& body = world_.bodies[rows_[k]];
    Vec6 before;
    before << body.linear_velocity() - reference_, body.angular_velocity();
    shift_.push_back((0.5 * h) * (work_.solution.velocity[k] - before));
  }
  move(h);
  close_gaps(h);
}

// Whether anything touching may bounce off: only then is there an impact law to apply.
bool IslandAdvance::rebounds() const {
  return std::any_of(contacts.begin(), contacts.end(), [this](const Contact& c) {
    if (!(c.material.restitution > 0.0) || !c.touching()) return false;
    const Vec3 point = place_of(world_.bodies, c).point;
    const double speed =
        -c.material.restitution * c.point.normal.dot(relative_velocity(
                                      world_.bodies[c.body_a], world_.bodies[c.body_b], point));
    return speed > tolerance::resting_speed && speed > rest_speed(c);
  });
}

// Takes out the overlap that the motion just made, with gaps that are linear in it.
void IslandAdvance::close_gaps(double h) {
  constexpr int most_sweeps = 24;
  constexpr double may_stay = 1e3;  // times the touch distance: the next step sees it
  ContactProblem& problem = work_.problem;
  const std::vector<Vec6>& v = work_.solution.velocity;
  double deepest = 0.0;
  double slack = INFINITY;
  for (std::size_t n = 0; n < active_.size(); ++n) {
    const Contact& contact = contacts[active_[n]];
    ContactConstraint& c = problem.contacts[n];
    // The bias of an open gap holds it already.
    double gap = h * relative_velocity(c, v).x();
    if (contact.touching()) gap += contact.point.separation;
    c.bias = Vec3(gap, 0.0, 0.0);
    deepest = std::fmax(deepest, -gap);
    slack = std::fmin(slack, may_stay * contact.touch);
  }
  if (!(deepest > slack)) return;
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    problem.velocity[k].setZero();
    const double turn = overlap_turn(deepest, world_.reach[rows_[k]]);
    problem.inv_inertia[k] =
        harmless_inverse_inertia(world_, rows_[k], problem.inv_inertia[k], turn);
  }
  const SeparationReport report =
      separate_bodies(problem, slack, most_sweeps, work_.solver.wide, work_.velocity_before);
  stats.iterations += report.sweeps;
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    shift_body(world_.bodies[rows_[k]], work_.velocity_before[k]);
  }
}

}  // namespace rb
