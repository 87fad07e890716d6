// The Zeno rule for rebounds that would end within the interval: a touching contact that parts now
// and carries force by the end of it was open for a moment only. The velocities at the end are
// right as they are; the displacement must not keep the height of a bounce that is over.
#include "math/rotation.hpp"
#include "solver/contact_operators.hpp"
#include "world/advance.hpp"
#include "world/pair_momentum.hpp"

namespace rb {

// Whether a gap closes within the interval, by the last solve.
bool IslandAdvance::closes_gap() const {
  for (std::size_t n = 0; n < active_.size(); ++n) {
    if (!contacts[active_[n]].touching() && work_.solution.impulse[n].x() > 0.0) return true;
  }
  return false;
}

void IslandAdvance::shift_to_end_velocities(double tau) {
  const IslandWorkspace& work = work_;
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const Body& body = world_.bodies[rows_[k]];
    Vec6 before;
    before << body.linear_velocity() - reference_, body.angular_velocity();
    shift_.push_back((0.5 * tau) * (work.solution.velocity[k] - before));
  }
}

void IslandAdvance::settle(double tau, bool last) {
  shift_.clear();
  pushed_.clear();
  // A gap that closes within the interval is bounded at the end's velocity: move with that one.
  if (closes_gap() || (free_ && last && at_start_)) return shift_to_end_velocities(tau);
  IslandWorkspace& work = work_;
  bool over = false;  // a rebound began and ended
  work_.settled.clear();
  for (std::size_t n = 0; n < active_.size(); ++n) {
    if (!contacts[active_[n]].touching()) continue;
    if (work.solution.impulse[n].x() > 0.0) {
      work_.settled.push_back(active_[n]);
      over |= slip_before_[n].x() > tolerance::resting_speed;
    }
  }
  if (!over) return;
  // The smallest change of velocity (in the metric of the masses) that takes the parting speeds
  // away and keeps the other loaded contacts closed: a complementarity problem with every normal
  // both ways round.
  const BodyIndex index{rows_, &world_.work.index_of, reference_};
  ContactProblem& problem = work_.settle_problem;
  build_bodies(world_.bodies, index, problem);
  std::vector<Vec6>& before = work_.velocity_before;
  before = problem.velocity;
  for (const std::int32_t i : work_.settled) {
    ContactPlace place = place_of(world_.bodies, contacts[i]);
    for (int way = 0; way < 2; ++way) {
      build_contact(world_.bodies, index, contacts[i], place, problem);
      ContactConstraint& c = problem.contacts.back();
      c.friction = c.static_friction = c.rolling_friction = c.spinning_friction = 0.0;
      place.normal = -place.normal;
    }
  }
  work_.settle_solution.impulse.assign(problem.contacts.size(), Vec3::Zero());
  work_.settle_solution.moment.clear();
  work_.settle_solution.certificate.clear();
  SolverSettings settings;
  settings.tolerance = settings.newton_goal =
      1e-9;  // of a displacement that is second order already
  settings.minimum_norm = false;
  solve_contacts(problem, settings, work_.settle_solution, work.solver);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    shift_.push_back((0.5 * tau) * (work_.settle_solution.velocity[k] - before[k]));
  }
  if (!free_) return;
  for (std::size_t n = 0; n < work_.settled.size(); ++n) {
    Vec3 push = Vec3::Zero();
    for (const std::size_t way : {2 * n, 2 * n + 1}) {
      push += problem.contacts[way].frame.transpose() * work_.settle_solution.impulse[way];
    }
    pushed_.push_back((0.5 * tau) * push);
  }
}

// What the shift did to x x p.
void IslandAdvance::return_angular_momentum() {
  for (std::size_t n = 0; n < pushed_.size(); ++n) {
    const Contact& c = contacts[work_.settled[n]];
    pushed_[n] = pushed_[n].cross(world_.bodies[c.body_a].linear_velocity() -
                                  world_.bodies[c.body_b].linear_velocity());
  }
  for (std::size_t n = 0; n < pushed_.size(); ++n) {
    Contact& c = contacts[work_.settled[n]];
    take_from_pair(world_.bodies[c.body_a], world_.bodies[c.body_b], c, pushed_[n]);
  }
}

void shift_body(Body& body, const Vec6& d) {
  body.state.x += d.head<3>();
  if (d.tail<3>().isZero(0.0)) return;
  const Quat turn = quaternion_from_rotation_vector(d.tail<3>());
  body.state.q = normalized(turn * body.state.q);
}

}  // namespace rb
