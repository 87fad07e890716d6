// Impacts at the present instant (S11-S15), by the chosen law.
#include <algorithm>
#include <cmath>

#include "contact/builder.hpp"
#include "solver/contact_operators.hpp"
#include "solver/impact_law.hpp"
#include "world/advance.hpp"

namespace rb {

// Whether any active contact may approach faster than rest explains: bodies at rest are spared the
// building of a problem. It errs to the safe side by more than rounding.
bool IslandAdvance::approaches() {
  constexpr double surely = 0.5;  // of the resting speed
  PairVelocities motion(world_.bodies);
  double linear = 0.0, angular_a = 0.0, angular_b = 0.0;  // speeds the relative velocity is made of
  relative_velocity_.resize(contacts.size());
  for (const std::int32_t i : active_) {
    const Contact& c = contacts[i];
    if (motion.look_at(c)) {
      const auto most = [](const Vec3& v) { return v.cwiseAbs().maxCoeff(); };
      linear = most(motion.a().linear) + most(motion.b().linear);
      angular_a = most(motion.a().angular);
      angular_b = most(motion.b().angular);
    }
    const Vec3 point = middle_of(c);
    const auto turning = [&](double angular, const Vec3& center) {
      return angular == 0.0 ? 0.0 : angular * (point - center).cwiseAbs().maxCoeff();
    };
    const double reach =
        linear + turning(angular_a, motion.a().center) + turning(angular_b, motion.b().center);
    relative_velocity_[i] = motion.relative_at(c, point);
    const double approach = -c.point.normal.dot(relative_velocity_[i]);
    if (approach <= surely * tolerance::resting_speed && reach < 1e4) continue;
    if (!drifts(i, approach) || c.material.restitution * approach > rest_speed(c)) return true;
  }
  return false;
}

// Whether the speed (m/s) of a contact that carries force may be what turning leaves in an interval
// whose geometry is that of its middle. The forces of the next one take it away.
bool IslandAdvance::drifts(std::int32_t contact, double speed) const {
  return work_.carried[contact] &&
         std::fabs(speed) * world_.settings.dt <= Contact::most_opened * contacts[contact].touch;
}

// Of what turns: which corners on faces carried force until now. What is round rolls: it settles
// often, and an energy that is lost each time would add up. The event stepper looks at intervals
// that are as short as it takes.
void IslandAdvance::look_who_carried() {
  const bool turns = world_.settings.stepper == Stepper::FIXED && turning(world_.settings.dt);
  work_.carried.assign(contacts.size(), 0);
  for (std::size_t i = 0; turns && i < contacts.size(); ++i)
    work_.carried[i] = contacts[i].warm_force.x() > 0.0 && is_flat(world_, contacts[i]);
}

// Where contacts open and fall shut all over, in every step, and there is nothing to look for.
bool IslandAdvance::takes_one_solve(double left) {
  const Settings& settings = world_.settings;
  const auto most = static_cast<std::size_t>(settings.max_event_contacts);
  if (settings.stepper != Stepper::FIXED || left != settings.dt || contacts.size() <= most ||
      coarse_piece_of(left, left) < left)
    return false;
  ContactProblem& problem = work_.settle_problem;
  build_bodies(world_.bodies, {rows_, &world_.work.index_of, reference_}, problem);
  for (const Contact& c : contacts) {
    problem.contacts.emplace_back();
    problem.contacts.back().a = world_.work.index_of[c.body_a];
    if (world_.bodies[c.body_b].is_dynamic())
      problem.contacts.back().b = world_.work.index_of[c.body_b];
  }
  mark();  // what may pass is asked of the states at the start
  return work_.graph.analyze(problem, SolverSettings{}.max_factor_work) && work_.graph.is_jam() &&
         !may_pass(left) && !rebound_ahead(left);
}

bool IslandAdvance::strike(double left) {
  IslandWorkspace& work = work_;
  bool struck = false;
  bool rebounds = false;
  bool hit = false;  // faster than what turning explains
  active_.clear();
  look_who_carried();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (contacts[i].touching()) active_.push_back(static_cast<std::int32_t>(i));
  }
  relative_known_ = false;
  if (active_.empty()) return true;
  if (!approaches()) {
    relative_known_ = true;
    return true;
  }
  const BodyIndex index{rows_, &world_.work.index_of, reference_};
  build_bodies(world_.bodies, index, work.problem);
  for (const std::int32_t i : active_) {
    const Contact& c = contacts[i];
    build_contact(world_.bodies, index, c, place_of(world_.bodies, c), work.problem);
    ContactConstraint& k = work.problem.contacts.back();
    const double approach = -relative_velocity(k, work.problem.velocity).x();
    // Even a slow approach is met at once, without rebound: spread over the step it would overlap.
    const bool rebound = k.restitution * approach > tolerance::resting_speed &&
                         k.restitution * approach > rest_speed(c);
    if (rebound || (approach > tolerance::resting_speed && !drifts(i, approach))) struck = true;
    rebounds |= rebound;
    hit |= approach > tolerance::resting_speed && approach > drift_speed(c);
  }
  if (!struck) return true;
  if (!rebounds && takes_one_solve(left)) return false;
  // The Zeno rule. Where anything rebounds, contacts that rest now may be struck next: they keep
  // their restitution.
  if (!rebounds) {
    for (ContactConstraint& k : work.problem.contacts) k.restitution = 0.0;
  }
  ImpactReport report;
  if (rebounds) {
    report = apply_impact(work.problem, world_.settings.impact_law, work.solution, work.solver);
  } else {
    // Without rebound all laws agree: the velocities nearest to v- that approach nowhere.
    work.solution.impulse.clear();
    work.solution.moment.clear();
    work.solution.certificate.clear();
    work.solution.vain_searches = 0;
    const SolveReport plain =
        solve_contacts(work.problem, solver_settings(), work.solution, work.solver);
    report.residual = plain.residual;
    report.iterations = plain.sweeps + plain.newton_steps;
  }
  ++stats.impacts;
  work_.carried.assign(contacts.size(), 0);  // what parts now rebounds
  stats.residual = std::fmax(stats.residual, report.residual);
  stats.iterations += report.iterations;
  stats.energy_error = std::fmax(stats.energy_error, report.energy_gain);
  for (std::size_t n = 0; n < active_.size(); ++n) {
    Contact& c = contacts[active_[n]];
    c.stuck &= !hit;
    const ContactConstraint& k = work.problem.contacts[n];
    const Vec3 impulse = k.frame.transpose() * work.solution.impulse[n];
    Vec3 moment = Vec3::Zero();
    if (!work.solution.moment.empty()) moment = k.frame.transpose() * work.solution.moment[n];
    add_impulse(c, k, impulse, moment);
    Body& a = world_.bodies[c.body_a];
    a.state.p += impulse;
    a.state.L += k.r_a.cross(impulse) + moment;
    Body& b = world_.bodies[c.body_b];
    if (b.is_dynamic()) {
      b.state.p -= impulse;
      b.state.L -= k.r_b.cross(impulse) + moment;
    }
  }
  return true;
}

}  // namespace rb
