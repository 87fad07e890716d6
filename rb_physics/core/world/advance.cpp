#include "world/advance.hpp"

#include <algorithm>
#include <cmath>

#include "body/free_motion.hpp"
#include "body/rk4.hpp"
#include "collision/iteration_caps.hpp"
#include "contact/builder.hpp"
#include "solver/contact_operators.hpp"
#include "world/contact_rates.hpp"
#include "world/detect.hpp"
#include "world/kinematic.hpp"
#include "world/seams.hpp"

namespace rb {

IslandAdvance::IslandAdvance(World& world, std::span<const std::int32_t> rows,
                             IslandWorkspace& work)
    : world_(world), rows_(rows), work_(work) {
  contacts.clear();
  departed.clear();
  pairs.clear();
  covered.clear();
  partners_.clear();
  partner_start_.clear();
  shift_.clear();
  total_.clear();
  for (std::size_t k = 0; k < rows.size(); ++k)
    world.work.index_of[rows[k]] = static_cast<std::int32_t>(k);
  for (const std::int32_t row : rows) total_.push_back(world.applied[row]);
}

void IslandAdvance::run(double h) {
  const Settings& settings = world_.settings;
  const bool event_stepper = settings.stepper == Stepper::EVENT;
  for (Contact& c : contacts) c.loaded = false;
  if (!event_stepper && is_large_island(contacts.size())) return run_in_one_solve(h);
  // Contact times are worth their price while the island is small; a heap closes its gaps within
  // one solve, but for those that open again and those that something fast turns away from. The
  // event stepper always takes them.
  const bool always =
      event_stepper || contacts.size() <= static_cast<std::size_t>(settings.max_event_contacts);
  // An event costs a solve: the more contacts, the fewer events.
  const int share = contacts.empty() ? settings.max_events
                                     : 8 * settings.max_events / static_cast<int>(contacts.size());
  const int most_events =
      event_stepper ? std::max(settings.max_events, 1000)
                    : std::clamp(share, std::min(2, settings.max_events), settings.max_events);
  // What moves fast enough to get through a wall has more.
  const int most_fast_events = most_events + 7 * std::min(most_events, settings.max_events);
  int events = 0;
  int pieces = 0;  // of what turns: each may part a contact that is struck again at once
  double left = h;
  find_partners();
  bool capped = false;
  caps_before_ = iteration_caps();
  while (true) {
    strike();
    mark();
    // A search that met its cap took as long as many.
    const auto work = events + 4 * (iteration_caps() - caps_before_) - pieces;
    const bool fast = (!always || work >= most_events) && may_pass(left);
    const bool by_events = always || fast || rebound_ahead(left);
    const bool spent = by_events && work >= (fast ? most_fast_events : most_events);
    hurried_ = fast && work >= most_events;
    capped |= spent;
    const bool guarded = spent && fast;  // then it waits where it meets something
    const bool last = !by_events || (spent && !fast);
    double tau = last ? left : piece_of(left);
    if (last) {
      carry_to_end(tau);
    } else {
      carry(tau, false);
    }
    bool event = false;
    if (!last) {
      const double stick = guarded ? tau : next_stick_time(tau);
      if (stick < tau) carry(stick, false);
      const double reached = std::fmin(stick, tau);
      const double contact = next_contact_time(reached);
      if (contact < reached) carry(contact, false);
      event = std::fmin(contact, reached) < tau;
      tau = std::fmin(contact, reached);
    }
    settle(tau, last);
    if (!last && stop_short(tau)) event = true;
    book();
    move(tau);
    take_back(tau);
    left -= tau;
    elapsed_ += tau;
    if (last || !(left > 1e-14 * h)) break;
    move_partners(elapsed_);
    if (guarded && event) {
      wait(left);
      break;
    }
    if (event) {
      ++events;
      ++stats.events;
    } else {
      ++pieces;
    }
    find_again();
  }
  move_partners(0.0);
  if (capped) ++stats.capped;
}

// Whether something moves so fast that it could be beyond the middle of what it meets within t.
bool IslandAdvance::may_pass(double t) const {
  constexpr double surely_not = 0.25;  // of both widths; it takes half of them
  return std::any_of(pairs.begin(), pairs.end(), [&](const ColliderPair& pair) {
    return closing_bound(pair, t) > surely_not * width_between(pair);
  });
}

// Gives the rest of the step's time up at a contact, t seconds before its end. A kinematic body
// that is met goes on, and takes the island along.
void IslandAdvance::wait(double t) {
  ++stats.waits;
  const Body& partner = world_.bodies[world_.colliders[met_.b].body];
  if (partner.type != BodyType::KINEMATIC) return;
  const Pose way = kinematic_pose(partner, t) * partner.pose().inverse();
  for (const std::int32_t row : rows_) {
    Body& body = world_.bodies[row];
    body.set_pose(way * body.pose());
    body.state.L = way.rotate(body.state.L);  // it keeps its energy
  }
}

void IslandAdvance::find_partners() {
  for (const ColliderPair& pair : pairs) {
    const std::int32_t row = world_.colliders[pair.b].body;
    if (world_.bodies[row].type != BodyType::KINEMATIC) continue;
    if (std::find(partners_.begin(), partners_.end(), row) != partners_.end()) continue;
    partners_.push_back(row);
    partner_start_.push_back(world_.bodies[row].state);
  }
  const bool on_static = std::any_of(pairs.begin(), pairs.end(), [this](const ColliderPair& pair) {
    return world_.bodies[world_.colliders[pair.b].body].type == BodyType::STATIC;
  });
  free_ = !on_static && partners_.empty();
  const std::int32_t leader = partners_.empty() ? rows_.front() : partners_.front();
  if (!on_static) reference_ = world_.bodies[leader].linear_velocity();
}

void IslandAdvance::move_partners(double t) {
  for (std::size_t k = 0; k < partners_.size(); ++k) {
    Body& body = world_.bodies[partners_[k]];
    body.state = partner_start_[k];
    const Pose pose = kinematic_pose(body, t);
    if (t > 0.0) body.set_pose(pose);
  }
}

// m/s: a rebound slower than this is rest: the next bounce would fit into a step, or the speed is
// what curvature and rotation bring about between two looks at a contact that stays closed.
double IslandAdvance::rest_speed(const Contact& c) const {
  const Body& a = world_.bodies[c.body_a];
  const Body& b = world_.bodies[c.body_b];
  if (world_.settings.restitution_threshold) return *world_.settings.restitution_threshold;
  const Vec3 r_a = c.point.point_a - a.state.x;
  const Vec3 r_b = c.point.point_b - b.state.x;
  const auto turn = [this](const Body& body, std::int32_t row, const Vec3& r) {
    if (!body.is_dynamic()) return 0.0;
    const Vec3 alpha = world_inverse_inertia(body.state.q, body.inertia) *
                       (world_.applied[row].torque - body.angular_velocity().cross(body.state.L));
    return alpha.cross(r).norm();
  };
  // The free motion's d'' (S10): none for a ball, however it rolls or spins.
  const ContactDrift drift = contact_drift(world_, c);
  const Vec3 slip = relative_velocity(a, b, c.point.point_a);
  const double swing =
      2.0 * std::abs(c.point.normal.dot(drift.velocity_rate) + drift.normal_rate.dot(slip));
  const auto pull = [this](const Body& body, std::int32_t row) {
    return body.is_dynamic() ? body.inertia.inv_mass * world_.applied[row].force.norm() : 0.0;
  };
  // A bounce of speed v lasts 2 v / g.
  const double bounce = 0.5 * std::fmax(pull(a, c.body_a), pull(b, c.body_b));
  return world_.settings.dt * (bounce + swing + turn(a, c.body_a, r_a) + turn(b, c.body_b, r_b));
}

// Whether a gap may close within `left` seconds so fast that it opens again: one solve would close
// it for good, however many contacts there are.
bool IslandAdvance::rebound_ahead(double left) const {
  constexpr double early = 1.5;  // forces may speed the approach up
  return std::any_of(contacts.begin(), contacts.end(), [&](const Contact& c) {
    if (c.touching() || !(c.material.restitution > 0.0)) return false;
    const Vec3 point = place_of(world_.bodies, c).point;
    const double approach = -c.point.normal.dot(
        relative_velocity(world_.bodies[c.body_a], world_.bodies[c.body_b], point));
    return early * approach * left > c.point.separation &&
           c.material.restitution * approach > rest_speed(c);
  });
}

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
  build_bodies(world_.bodies, index, problem);
  if (!(far_too && (at_start_ || !free_)) && turning(tau)) {
    build_midpoint(index, tau);
  } else {
    for (const std::int32_t i : active_) {
      build_contact(world_.bodies, index, contacts[i], place_of(world_.bodies, contacts[i]),
                    problem);
    }
  }
  slip_before_.clear();
  double drift = 0.0;  // m/s
  for (std::size_t n = 0; n < active_.size(); ++n) {
    const Contact& contact = contacts[active_[n]];
    ContactConstraint& c = problem.contacts[n];
    const Vec3 u =
        c.frame * relative_velocity(world_.bodies[contact.body_a], world_.bodies[contact.body_b],
                                    place_of(world_.bodies, contact).point);
    slip_before_.push_back(u);
    // A contact that slides already has no static friction to overcome.
    const bool slides = u.tail<2>().norm() > stick_speed();
    if (slides) c.static_friction = 0.0;
    if (contact.touching()) drift = std::fmax(drift, slides ? std::abs(u.x()) : u.norm());
  }
  // The velocities the problem constrains are those at the end of the interval, free of contact
  // forces.
  double gain = 0.0;  // m/s that the contact forces take away: what they are right to
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const Body& body = world_.bodies[rows_[k]];
    const RigidState end = move_free(body.state, body.inertia, total_[k], tau);
    problem.velocity[k] << linear_velocity(end, body.inertia) - reference_,
        angular_velocity(end, body.inertia);
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
  for (std::size_t k = 0; k < rows_.size(); ++k)
    solution.certificate[k] = tau * world_.bodies[rows_[k]].certificate;
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
      const bool slides = u.tail<2>().norm() > stick_speed();
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
    world_.bodies[rows_[k]].certificate =
        solution.certificate.empty() ? Vec6::Zero() : Vec6(solution.certificate[k] / tau);
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
  for (Contact& c : contacts) c.loaded = false;
  for (std::size_t n = 0; n < active_.size(); ++n) {
    Contact& c = contacts[active_[n]];
    const ContactConstraint& k = work.problem.contacts[n];
    c.loaded = work.solution.impulse[n].x() > 0.0;
    add_impulse(c, k, k.frame.transpose() * work.solution.impulse[n],
                work.solution.moment.empty() ? Vec3::Zero()
                                             : Vec3(k.frame.transpose() * work.solution.moment[n]));
  }
}

void IslandAdvance::mark() {
  start_.clear();
  for (const std::int32_t row : rows_) start_.push_back(world_.bodies[row].state);
}

void IslandAdvance::move(double tau) {
  for (std::size_t k = 0; k < rows_.size(); ++k) move_body(k, tau);
}

void IslandAdvance::move_body(std::size_t k, double tau) {
  const bool rk4 = world_.settings.free_motion == FreeMotion::RK4;
  Body& body = world_.bodies[rows_[k]];
  body.state = rk4 ? rk4_step(start_[k], body.inertia, total_[k], tau)
                   : move_free(start_[k], body.inertia, total_[k], tau);
  if (!shift_.empty()) shift_body(body, shift_[k]);
}

void IslandAdvance::find_again() {
  found_again = true;
  work_.found.clear();
  for (const ColliderPair& pair : pairs)
    append_contacts(world_, pair, pair_margin(world_, pair), work_.points, work_.found);
  cover_seams(world_, work_.found);
  covered.clear();
  for (const Contact& c : work_.found) {
    if (c.role == ContactRole::COVERED) covered.push_back({c.collider_a, c.collider_b});
  }
  std::erase_if(work_.found, [](const Contact& c) { return !c.active(); });
  carry_over(contacts, work_.found, &departed);
  contacts.swap(work_.found);
}

}  // namespace rb
