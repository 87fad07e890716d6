// A large island over a whole step: impacts, rest and friction in one solve (Moreau), in which
// every gap within reach is a constraint; bodies move with the velocities it ends at. What that
// solve left open of the gaps is put right by the least displacement, which no momentum sees.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <numeric>

#include "body/free_motion.hpp"
#include "math/tolerances.hpp"
#include "solver/contact_operators.hpp"
#include "solver/separation.hpp"
#include "world/advance.hpp"
#include "world/correct.hpp"
#include "world/step.hpp"

namespace rb {

namespace {

constexpr std::size_t kFewContacts = 128;  // not worth another thread
constexpr std::size_t kFewBodies = 32;

bool has_moments(const Contact& c) {
  return c.material.rolling_friction > 0.0 || c.material.spinning_friction > 0.0;
}

}  // namespace

bool IslandAdvance::take_contacts(std::span<const std::int32_t> edges) {
  if (world_.settings.stepper != Stepper::FIXED || !is_large_island(edges.size()) ||
      2 * edges.size() < world_.contacts.size()) {
    return false;
  }
  for (const std::int32_t i : edges) {
    const Contact& c = world_.contacts[i];
    if (!c.active()) continue;
    active_.push_back(i);
    if (pairs.empty() || pairs.back().a != c.collider_a || pairs.back().b != c.collider_b)
      pairs.push_back({c.collider_a, c.collider_b});
  }
  among_others_ = is_large_island(active_.size());
  if (among_others_) {
    contacts.swap(world_.contacts);
  } else {
    pairs.clear();
  }
  return among_others_;
}

void IslandAdvance::run_in_one_solve(double h) {
  WideContacts& wide = work_.solver.wide;
  wide.use(&world_.work.crew);
  wide.forget();
  if (!among_others_) {
    active_.resize(contacts.size());
    std::iota(active_.begin(), active_.end(), 0);
  }
  find_partners();
  const Materials materials = look_at_materials();
  if (among_others_ && (materials.rebound || materials.moments)) {
    solve_apart(h, materials);
  } else {
    solve_at_once(h, materials);
  }
  wide.use(nullptr);
}

// An island of some hundred contacts, which has its own.
void IslandAdvance::take_at_once(double h) {
  work_.solver.wide.forget();
  active_.resize(contacts.size());
  std::iota(active_.begin(), active_.end(), 0);
  solve_at_once(h, {false, look_at_materials().moments});
}

// With copies of its contacts in place of the whole list.
void IslandAdvance::solve_apart(double h, const Materials& materials) {
  std::vector<Contact>& all = work_.of_all;
  std::vector<std::int32_t>& own = work_.own;
  own = active_;
  all.swap(contacts);
  contacts.clear();
  for (const std::int32_t i : own) contacts.push_back(all[i]);
  solve_at_once(h, materials);
  for (std::size_t n = 0; n < own.size(); ++n) all[own[n]] = contacts[n];
  all.swap(contacts);
}

void IslandAdvance::solve_at_once(double h, const Materials& materials) {
  if (materials.rebound) {
    strike(0.0);  // which lists those that touch only
    active_.resize(contacts.size());
    std::iota(active_.begin(), active_.end(), 0);
  }
  shift_.clear();
  shift_.resize(rows_.size());
  mark();
  if (materials.moments) {
    carry(h, true);
    book();
  } else {
    hold(h);
  }
  work_.solver.wide.share_range(rows_.size(), kFewBodies, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Body& body = world_.bodies[rows_[k]];
      Vec6 before;
      before << body.linear_velocity() - reference_, body.angular_velocity();
      shift_[k] = (0.5 * h) * (work_.solution.velocity[k] - before);
    }
  });
  work_.solver.wide.share_range(rows_.size(), kFewBodies, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) move_body(k, h);
  });
  // Small ones have their overlaps looked at by correct_positions.
  const bool closed = is_large_island(active_.size()) && close_gaps(h);
  take_back_at_once(h, closed);
}

// What `take_back` does for small islands, where the island gained anything.
void IslandAdvance::take_back_at_once(double h, bool closed) {
  std::vector<BodyGain>& gains = work_.gains;
  gains.resize(rows_.size());
  pushed_ = false;
  work_.solver.wide.share_range(rows_.size(), kFewBodies, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      gains[k] = gain_of(k, h);
      if (!closed || !free_) continue;
      const Body& body = world_.bodies[rows_[k]];
      gains[k].angular = work_.velocity_before[k].head<3>().cross(
          body.inertia.mass * (body.linear_velocity() - reference_));
    }
  });
  double energy = 0.0;
  for (const BodyGain& gain : gains) energy += gain.energy;
  if (!(energy > 0.0) && !(closed && free_)) return;
  std::vector<std::int32_t>& links = work_.settled;
  links.clear();
  for (std::size_t n = 0; n < active_.size(); ++n) {
    if (closed || !work_.solution.impulse[n].isZero(0.0)) links.push_back(active_[n]);
  }
  take_back_gains(world_, rows_, contacts, links, gains, reference_, work_.groups);
}

// What `carry` and `book` do for small islands, with every gap within reach and nothing else to
// look for: sweeps end before the last digits that the rest would need.
void IslandAdvance::hold(double h) {
  const std::size_t nc = active_.size();
  const BodyIndex index{rows_, &world_.work.index_of, reference_};
  ContactProblem& problem = work_.problem;
  ContactSolution& solution = work_.solution;
  problem.inv_mass.resize(rows_.size());
  problem.inv_inertia.resize(rows_.size());
  problem.velocity.resize(rows_.size());
  work_.solver.wide.share_range(rows_.size(), kFewBodies, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      build_body(world_.bodies, index, k, problem);
      Body& body = world_.bodies[rows_[k]];
      body.certificate = Vec6::Zero();
      body.vain_searches = 0;
      total_[k] = world_.applied[rows_[k]];
      problem.velocity[k] = velocities_after(body.state, body.inertia, total_[k], h);
      problem.velocity[k].head<3>() -= reference_;
    }
  });
  problem.contacts.resize(nc);
  solution.impulse.resize(nc);
  work_.solver.wide.share_range(nc, kFewContacts, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Contact& contact = contacts[active_[i]];
      const ContactPlace place = place_of(world_.bodies, contact);
      ContactConstraint& c = problem.contacts[i];
      set_constraint(world_.bodies, index, contact, place, c);
      if (c.static_friction > c.friction) {
        const Vec3 u = c.frame * relative_velocity(world_.bodies[contact.body_a],
                                                   world_.bodies[contact.body_b], place.point);
        if (u.tail<2>().norm() > stick_speed()) c.static_friction = 0.0;
      }
      if (!contact.touching()) c.bias.x() += contact.point.separation / h;
      solution.impulse[i] = h * contact.warm_force;
    }
  });
  solution.moment.clear();
  solution.certificate.clear();
  solution.vain_searches = 0;
  const SolveReport report = solve_contacts(problem, solver_settings(), solution, work_.solver);
  stats.residual = std::fmax(stats.residual, report.residual);
  stats.iterations += report.sweeps + report.newton_steps;
  if (report.work_exhausted) ++stats.capped;
  work_.solver.wide.share_range(nc, kFewContacts, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const ContactConstraint& c = problem.contacts[i];
      Contact& contact = contacts[active_[i]];
      contact.warm_force = solution.impulse[i] / h;
      add_impulse(contact, c, c.frame.transpose() * solution.impulse[i], Vec3::Zero());
    }
  });
  add_forces(h);
}

// What else there is to do for an island than to hold its contacts, which are not loaded yet.
IslandAdvance::Materials IslandAdvance::look_at_materials() {
  std::atomic<bool> rebound = false, moments = false;
  const auto bounces = [this](const Contact& c) {
    if (!(c.material.restitution > 0.0) || !c.touching()) return false;
    const Vec3 point = place_of(world_.bodies, c).point;
    const double speed =
        -c.material.restitution * c.point.normal.dot(relative_velocity(
                                      world_.bodies[c.body_a], world_.bodies[c.body_b], point));
    return speed > tolerance::resting_speed && speed > rest_speed(c);
  };
  work_.solver.wide.share_range(active_.size(), kFewContacts, [&](std::size_t n, std::size_t end) {
    for (; n < end; ++n) {
      Contact& c = contacts[active_[n]];
      c.loaded = false;
      if (has_moments(c)) moments = true;
      if (!rebound && bounces(c)) rebound = true;
    }
  });
  return {rebound, moments};
}

// Takes out the overlap that the motion just made, with gaps that are linear in it. Returns whether
// there was any; the displacements are in `velocity_before`.
bool IslandAdvance::close_gaps(double h) {
  constexpr int most_sweeps = 24;
  constexpr double may_stay = 3e3;  // times the touch distance: the next step sees it
  constexpr double share = 0.25;    // of what moves so much that the next step has as much again
  ContactProblem& problem = work_.problem;
  const std::vector<Vec6>& v = work_.solution.velocity;
  double deepest = 0.0;
  double slack = INFINITY;
  std::mutex mutex;
  WideContacts& wide = work_.solver.wide;
  wide.share_range(active_.size(), kFewContacts, [&](std::size_t begin, std::size_t end) {
    double my_deepest = 0.0, my_slack = INFINITY;
    for (std::size_t n = begin; n < end; ++n) {
      const Contact& contact = contacts[active_[n]];
      ContactConstraint& c = problem.contacts[n];
      // The bias of an open gap holds it already.
      double gap = h * relative_velocity(c, v).x();
      if (contact.touching()) gap += contact.point.separation;
      c.bias = Vec3(gap, 0.0, 0.0);
      my_deepest = std::fmax(my_deepest, -gap);
      my_slack = std::fmin(my_slack, may_stay * contact.touch);
    }
    const std::lock_guard lock(mutex);
    deepest = std::fmax(deepest, my_deepest);
    slack = std::fmin(slack, my_slack);
  });
  if (!(deepest > slack)) return false;
  wide.share_range(rows_.size(), kFewBodies, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      problem.velocity[k].setZero();
      const double turn = overlap_turn(deepest, world_.reach[rows_[k]]);
      problem.inv_inertia[k] =
          harmless_inverse_inertia(world_, rows_[k], problem.inv_inertia[k], turn);
    }
  });
  slack = std::fmax(slack, share * deepest);
  const SeparationReport report =
      separate_bodies(problem, slack, most_sweeps, wide, work_.velocity_before);
  stats.iterations += report.sweeps;
  wide.share_range(rows_.size(), kFewBodies, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      shift_body(world_.bodies[rows_[k]], work_.velocity_before[k]);
    }
  });
  return true;
}

}  // namespace rb
