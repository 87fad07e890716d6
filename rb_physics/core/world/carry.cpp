// Forces of contacts over the next interval: one cone complementarity problem (S16), in velocities.
#include <algorithm>
#include <cmath>

#include "body/free_motion.hpp"
#include "contact/builder.hpp"
#include "solver/contact_operators.hpp"
#include "world/advance.hpp"

namespace rb {

void IslandAdvance::add_impulse(Contact& c, const ContactConstraint& k, const Vec3& impulse,
                                const Vec3& moment) {
  c.impulse += impulse;
  c.moment_a += k.r_a.cross(impulse) + moment;
  c.moment_b -= k.r_b.cross(impulse) + moment;
}

SolverSettings IslandAdvance::solver_settings() const {
  SolverSettings settings;
  settings.tolerance = world_.settings.tolerance;
  // Last step's forces serve again as long as they leave next to nothing: a stack under constant
  // forces is an inverted pendulum, what they leave grows.
  settings.warm_tolerance = settings.tolerance;
  settings.newton_goal = 0.1 * settings.tolerance;
  settings.max_work = world_.settings.max_work;
  settings.enough = 1e-9;  // a tenth of what any island may report
  settings.newton_attempts = active_.size() <= 64 ? 16 : 4;  // a jam of few contacts is worth it
  if (is_large_island(active_.size())) {
    const auto nc = static_cast<double>(active_.size());
    // A factorisation must not cost more than a few sweeps, as in a tower.
    settings.max_factor_work = std::fmin(settings.max_factor_work, 150.0 * nc);
    settings.max_sweeps = std::clamp(static_cast<int>(6e4 / nc), 8, 150);
  }
  return settings;
}

// The rest of the step in one solve. Where a gap closes, the bodies move with the velocities of the
// end (settle.cpp), and the angular momentum of a free island stays if its arms are those of the
// start; where none does, if they are those of the midpoint.
void IslandAdvance::carry_to_end(double tau) {
  at_start_ = true;
  if (free_) {
    at_start_ = std::any_of(contacts.begin(), contacts.end(), [&](const Contact& c) {
      const Vec3 u = relative_velocity(world_.bodies[c.body_a], world_.bodies[c.body_b],
                                       place_of(world_.bodies, c).point);
      return !c.touching() && c.point.separation + tau * c.point.normal.dot(u) < 0.0;
    });
  }
  carry(tau, true);
  if (at_start_ || !closes_gap()) return;
  at_start_ = true;
  carry(tau, true);
}

// m/s: a speed of the contact up to which it may be what the midpoint rule leaves of its turning,
// of second order in the angle; relative to those it is the difference of.
double IslandAdvance::drift_speed(const Contact& c) const {
  constexpr double share = 1e-3;
  const Vec3 point = place_of(world_.bodies, c).point;
  const auto surface_speed = [&](const Body& body) {
    return (body.linear_velocity() - reference_).norm() +
           body.angular_velocity().cross(point - body.state.x).norm();
  };
  return share * (surface_speed(world_.bodies[c.body_a]) + surface_speed(world_.bodies[c.body_b]));
}

// Whether a contact of slip u (m/s, contact frame) slides. One that stuck drifts.
bool IslandAdvance::slides(const Contact& c, const Vec3& u) const {
  const double slip = u.tail<2>().norm();
  return slip > stick_speed() && !(c.stuck && slip <= drift_speed(c));
}

void IslandAdvance::carry(double tau, bool far_too) {
  IslandWorkspace& work = work_;
  for (std::size_t k = 0; k < rows_.size(); ++k) total_[k] = world_.applied[rows_[k]];
  active_.clear();
  residual_ = 0.0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (far_too || contacts[i].touching()) active_.push_back(static_cast<std::int32_t>(i));
  }
  if (active_.empty()) return;
  const BodyIndex index{rows_, &world_.work.index_of, reference_};
  ContactProblem& problem = work.problem;
  ContactSolution& solution = work.solution;
  if (!(far_too && (at_start_ || !free_)) && turning(tau)) {
    build_bodies(world_.bodies, index, problem);
    build_midpoint(index, tau);
  } else {
    problem.contacts.resize(active_.size());  // what stands there is written over
    for (std::size_t n = 0; n < active_.size(); ++n) {
      const Contact& c = contacts[active_[n]];
      set_constraint(world_.bodies, index, c, place_of(world_.bodies, c), problem.contacts[n]);
    }
    problem.inv_mass.resize(rows_.size());
    problem.inv_inertia.resize(rows_.size());
    problem.velocity.resize(rows_.size());  // below
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      const Body& body = world_.bodies[rows_[k]];
      problem.inv_mass[k] = body.inertia.inv_mass;
      problem.inv_inertia[k] = world_inverse_inertia(body.state.q, body.inertia);
    }
  }
  slip_before_.clear();
  double drift = 0.0;  // m/s
  PairVelocities motion(world_.bodies);
  for (std::size_t n = 0; n < active_.size(); ++n) {
    const Contact& contact = contacts[active_[n]];
    ContactConstraint& c = problem.contacts[n];
    const Vec3 u = c.frame * (relative_known_ && contact.touching()
                                  ? relative_velocity_[active_[n]]
                                  : motion.relative_at(contact, middle_of(contact)));
    slip_before_.push_back(u);
    // A contact that slides already has no static friction to overcome.
    const bool slides = this->slides(contact, u);
    if (slides) c.static_friction = 0.0;
    if (contact.touching()) drift = std::fmax(drift, slides ? std::abs(u.x()) : u.norm());
  }
  // The velocities the problem constrains are those at the end of the interval, free of contact
  // forces.
  double gain = 0.0;  // m/s that the contact forces take away: what they are right to
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const Body& body = world_.bodies[rows_[k]];
    problem.velocity[k] = velocities_after(body.state, body.inertia, total_[k], tau);
    problem.velocity[k].head<3>() -= reference_;
    const Vec3 before = body.linear_velocity() - reference_;
    gain = std::fmax(gain, (problem.velocity[k].head<3>() - before).norm());
  }
  solution.impulse.resize(active_.size());
  solution.moment.clear();
  bool moments = false;
  for (std::size_t n = 0; n < active_.size(); ++n) {
    const Contact& c = contacts[active_[n]];
    solution.impulse[n] = tau * c.warm_force;
    if (!c.touching()) problem.contacts[n].bias.x() += c.point.separation / tau;
    moments |= c.material.rolling_friction > 0.0 || c.material.spinning_friction > 0.0;
  }
  if (moments) {
    for (const std::int32_t i : active_) solution.moment.push_back(tau * contacts[i].warm_moment);
  }
  solution.certificate.resize(rows_.size());
  // Now and then there is one search more: what changes slowly may have a certificate by then.
  constexpr std::uint64_t now_and_then = 64;  // steps
  solution.vain_searches = most_vain_searches - (world_.step_count % now_and_then == 0);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const Body& body = world_.bodies[rows_[k]];
    solution.certificate[k] = tau * body.certificate;
    solution.vain_searches = std::min(solution.vain_searches, body.vain_searches);
  }
  SolverSettings settings = solver_settings();
  settings.warm_speed = 5.0 * settings.tolerance * gain;
  const SolveReport report = solve_contacts(problem, settings, solution, work.solver);
  residual_ = report.residual;
  stats.iterations += report.sweeps + report.newton_steps;
  if (report.work_exhausted) ++stats.capped;
  add_forces(tau);
  if (report.warm_accepted) return;
  work.steady = solution;         // always, so that later steps need no memory
  constexpr double small = 1e-9;  // relative: the forces are last step's but for what drifted
  const double still =
      std::fmin(settings.newton_goal * report.typical_velocity, 0.1 * settings.warm_speed);
  if (report.start_residual <= small && drift > still) {
    without_drift(tau, settings.warm_speed);
  } else {
    remember_forces(tau, solution);
  }
}

// The forces of now also stop what earlier ones have left: the next step would hum with them. It
// starts from the answer for contacts that were at rest before.
void IslandAdvance::without_drift(double tau, double warm_speed) {
  IslandWorkspace& work = work_;
  const auto shift_bias = [&](double sign) {
    for (std::size_t n = 0; n < active_.size(); ++n) {
      if (!contacts[active_[n]].touching()) continue;
      const Vec3& u = slip_before_[n];
      const bool slides = this->slides(contacts[active_[n]], u);
      work.problem.contacts[n].bias += sign * (slides ? Vec3(u.x(), 0.0, 0.0) : u);
    }
  };
  shift_bias(-1.0);
  SolverSettings settings = solver_settings();
  settings.warm_tolerance = 0.1 * settings.newton_goal;
  settings.warm_speed = warm_speed;
  const SolveReport report = solve_contacts(work.problem, settings, work.steady, work.solver);
  shift_bias(1.0);
  stats.iterations += report.sweeps + report.newton_steps;
  remember_forces(tau, work.steady);
}

// The next solve, of another tau or the next step, starts from here.
void IslandAdvance::remember_forces(double tau, const ContactSolution& solution) {
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    Body& body = world_.bodies[rows_[k]];
    body.certificate =
        solution.certificate.empty() ? Vec6::Zero() : Vec6(solution.certificate[k] / tau);
    body.vain_searches = solution.vain_searches;
  }
  for (std::size_t n = 0; n < active_.size(); ++n) {
    Contact& contact = contacts[active_[n]];
    contact.warm_force = solution.impulse[n] / tau;
    if (!solution.moment.empty()) contact.warm_moment = solution.moment[n] / tau;
  }
}

void IslandAdvance::add_forces(double tau) {
  const ContactProblem& problem = work_.problem;
  const ContactSolution& solution = work_.solution;
  for (std::size_t n = 0; n < active_.size(); ++n) {
    const ContactConstraint& c = problem.contacts[n];
    const Vec3 force = c.frame.transpose() * (solution.impulse[n] / tau);
    Vec3 moment = Vec3::Zero();
    if (!solution.moment.empty()) moment = c.frame.transpose() * (solution.moment[n] / tau);
    total_[c.a].force += force;
    total_[c.a].torque += c.r_a.cross(force) + moment;
    if (c.b < 0) continue;
    total_[c.b].force -= force;
    total_[c.b].torque -= c.r_b.cross(force) + moment;
  }
}

void IslandAdvance::book() {
  stats.residual = std::fmax(stats.residual, residual_);
  const IslandWorkspace& work = work_;
  const bool moments = !work.solution.moment.empty();
  for (Contact& c : contacts) c.loaded = c.stuck = false;
  for (std::size_t n = 0; n < active_.size(); ++n) {
    Contact& c = contacts[active_[n]];
    const ContactConstraint& k = work.problem.contacts[n];
    c.loaded = work.solution.impulse[n].x() > 0.0;
    c.stuck = c.loaded && c.sticks_under(work.solution.impulse[n]);
    const Vec3 impulse = k.frame.transpose() * work.solution.impulse[n];
    if (!moments) {
      c.impulse += impulse;
      c.moment_a += k.r_a.cross(impulse);
      c.moment_b -= k.r_b.cross(impulse);
    } else {
      add_impulse(c, k, impulse, k.frame.transpose() * work.solution.moment[n]);
    }
  }
}

}  // namespace rb
