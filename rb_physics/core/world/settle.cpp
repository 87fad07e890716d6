// The Zeno rule for rebounds that would end within the interval: a touching contact that parts now
// and carries force by the end of it was open for a moment only. The velocities at the end are
// right as they are; the displacement must not keep the height of a bounce that is over.
#include "body/state.hpp"
#include "math/rotation.hpp"
#include "solver/closing.hpp"
#include "solver/contact_operators.hpp"
#include "world/advance.hpp"

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
  pushed_ = false;
  // A gap that closes within the interval is bounded at the end's velocity: move with that one.
  if (closes_gap() || (free_ && last && at_start_)) return shift_to_end_velocities(tau);
  IslandWorkspace& work = work_;
  bool over = false;  // a rebound began and ended
  work_.settled.clear();
  for (std::size_t n = 0; n < active_.size(); ++n) {
    if (!contacts[active_[n]].touching()) continue;
    if (work.solution.impulse[n].x() > 0.0) {
      work_.settled.push_back(active_[n]);
      const double parting = slip_before_[n].x();
      over |= parting > tolerance::resting_speed;
    }
  }
  if (!over) return;
  // The smallest change of velocity (in the metric of the masses) that takes the parting speeds
  // away and keeps the other loaded contacts closed.
  const BodyIndex index{rows_, &world_.work.index_of, reference_};
  ContactProblem& problem = work_.settle_problem;
  build_bodies(world_.bodies, index, problem);
  for (const std::int32_t i : work_.settled) {
    build_contact(world_.bodies, index, contacts[i], place_of(world_.bodies, contacts[i]), problem);
    ContactConstraint& c = problem.contacts.back();
    c.bias = Vec3(relative_velocity(c, problem.velocity).x(), 0.0, 0.0);
  }
  work_.closed.assign(problem.contacts.size(), 1);
  std::vector<Vec6>& change = work_.velocity_before;
  if (!close_contacts(problem, work_.closed, SolverSettings{}.max_factor_work, work_.solver.space,
                      work_.closing, change))
    return shift_to_end_velocities(tau);
  for (const Vec6& v : change) shift_.push_back((0.5 * tau) * v);
  pushed_ = true;
}

// What body k gained over tau, by contact forces on its way and by the shift.
BodyGain IslandAdvance::gain_of(std::size_t k, double tau) const {
  const Body& body = world_.bodies[rows_[k]];
  const RigidState& start = start_[k];
  const Wrench& outside = world_.applied[rows_[k]];
  const Vec3 v0 = linear_velocity(start, body.inertia) - reference_;
  const Vec3 v1 = body.linear_velocity() - reference_;
  const Vec3 w0 = angular_velocity(start, body.inertia);
  const Vec3 w1 = body.angular_velocity();
  const Vec3 mean = 0.5 * (v0 + v1);
  BodyGain gain;
  gain.impulse = tau * (total_[k].force - outside.force);
  gain.energy = gain.impulse.dot(mean) + 0.5 * (body.state.L.dot(w1) - start.L.dot(w0));
  if (!outside.torque.isZero(0.0)) {
    // Half of it acts at the start, half at the end (body/free_motion.cpp).
    const Vec3 kick = (0.5 * tau) * total_[k].torque;
    const Vec3 kicked = w0 + world_inverse_inertia(start.q, body.inertia) * kick;
    const Vec3 unkicked = w1 - world_inverse_inertia(body.state.q, body.inertia) * kick;
    gain.energy -= (0.25 * tau) * outside.torque.dot(w0 + kicked + unkicked + w1);
  }
  if (shift_.empty()) return gain;
  const Vec3 shift = shift_[k].head<3>();
  gain.energy -= outside.force.dot(shift);
  if (pushed_) gain.angular = shift.cross(body.inertia.mass * v1);
  return gain;
}

void IslandAdvance::take_back(double tau) {
  if (active_.empty() || (shift_.empty() && !turning(tau))) return;
  std::vector<std::int32_t>& links = work_.settled;
  links.clear();
  for (std::size_t n = 0; n < active_.size(); ++n) {
    if (!work_.solution.impulse[n].isZero(0.0)) links.push_back(active_[n]);
  }
  if (links.empty()) return;
  work_.gains.clear();
  for (std::size_t k = 0; k < rows_.size(); ++k) work_.gains.push_back(gain_of(k, tau));
  take_back_gains(world_, rows_, contacts, links, work_.gains, reference_, work_.groups);
}

void shift_body(Body& body, const Vec6& d) {
  body.state.x += d.head<3>();
  if (d.tail<3>().isZero(0.0)) return;
  const Quat turn = quaternion_from_rotation_vector(d.tail<3>());
  body.state.q = normalized(turn * body.state.q);
}

}  // namespace rb
