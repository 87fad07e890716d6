// A large island over a whole step: impacts, rest and friction in one solve (Moreau), in which
// every gap within reach is a constraint; bodies move with the velocities it ends at. What that
// solve left open of the gaps is put right by the least displacement, which no momentum sees.
#include <algorithm>
#include <cmath>

#include "body/free_motion.hpp"
#include "math/tolerances.hpp"
#include "solver/contact_operators.hpp"
#include "solver/separation.hpp"
#include "world/advance.hpp"
#include "world/correct.hpp"
#include "world/step.hpp"

namespace rb {

namespace {

constexpr std::size_t kBlock = 256;  // contacts or bodies a thread takes at once

// piece(begin, end) over blocks of [0, n), shared among the threads.
template <class Piece>
void in_blocks(WideContacts& wide, std::size_t n, const Piece& piece) {
  wide.share(static_cast<std::int32_t>((n + kBlock - 1) / kBlock), [&](std::int32_t k) {
    const std::size_t begin = static_cast<std::size_t>(k) * kBlock;
    piece(begin, std::min(n, begin + kBlock));
  });
}

bool has_moments(const Contact& c) {
  return c.material.rolling_friction > 0.0 || c.material.spinning_friction > 0.0;
}

}  // namespace

void IslandAdvance::run_in_one_solve(double h) {
  WideContacts& wide = work_.solver.wide;
  wide.use(world_.settings.threads > 1 ? &workers_of(world_) : nullptr);
  wide.together([&] { solve_at_once(h); });
  wide.use(nullptr);
}

void IslandAdvance::solve_at_once(double h) {
  find_partners();
  if (rebounds()) strike();
  shift_.clear();
  shift_.resize(rows_.size());
  mark();
  if (std::any_of(contacts.begin(), contacts.end(), has_moments)) {
    carry(h, true);
    book();
  } else {
    hold(h);
  }
  in_blocks(work_.solver.wide, rows_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Body& body = world_.bodies[rows_[k]];
      Vec6 before;
      before << body.linear_velocity() - reference_, body.angular_velocity();
      shift_[k] = (0.5 * h) * (work_.solution.velocity[k] - before);
    }
  });
  move(h);
  close_gaps(h);
}

// What `carry` and `book` do for small islands, with every gap within reach and nothing else to
// look for: sweeps end before the last digits that the rest would need.
void IslandAdvance::hold(double h) {
  const std::size_t nc = contacts.size();
  const BodyIndex index{rows_, &world_.work.index_of, reference_};
  ContactProblem& problem = work_.problem;
  ContactSolution& solution = work_.solution;
  build_bodies(world_.bodies, index, problem);
  in_blocks(work_.solver.wide, rows_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Body& body = world_.bodies[rows_[k]];
      total_[k] = world_.applied[rows_[k]];
      const RigidState after = move_free(body.state, body.inertia, total_[k], h);
      problem.velocity[k] << linear_velocity(after, body.inertia) - reference_,
          angular_velocity(after, body.inertia);
    }
  });
  problem.contacts.resize(nc);
  solution.impulse.resize(nc);
  active_.resize(nc);
  in_blocks(work_.solver.wide, nc, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Contact& contact = contacts[i];
      const ContactPlace place = place_of(world_.bodies, contact);
      ContactConstraint& c = problem.contacts[i];
      c = make_constraint(world_.bodies, index, contact, place);
      if (c.static_friction > c.friction) {
        const Vec3 u = c.frame * relative_velocity(world_.bodies[contact.body_a],
                                                   world_.bodies[contact.body_b], place.point);
        if (u.tail<2>().norm() > stick_speed()) c.static_friction = 0.0;
      }
      if (!contact.touching()) c.bias.x() += contact.point.separation / h;
      solution.impulse[i] = h * contact.warm_force;
      active_[i] = static_cast<std::int32_t>(i);
    }
  });
  solution.moment.clear();
  solution.certificate.clear();
  const SolveReport report = solve_contacts(problem, solver_settings(), solution, work_.solver);
  stats.residual = std::fmax(stats.residual, report.residual);
  stats.iterations += report.sweeps + report.newton_steps;
  if (report.work_exhausted) ++stats.capped;
  for (const std::int32_t row : rows_) world_.bodies[row].certificate = Vec6::Zero();
  in_blocks(work_.solver.wide, nc, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const ContactConstraint& c = problem.contacts[i];
      contacts[i].warm_force = solution.impulse[i] / h;
      add_impulse(contacts[i], c, c.frame.transpose() * solution.impulse[i], Vec3::Zero());
    }
  });
  for (std::size_t i = 0; i < nc; ++i) {
    const ContactConstraint& c = problem.contacts[i];
    if (solution.impulse[i].isZero(0.0)) continue;
    const Vec3 force = c.frame.transpose() * (solution.impulse[i] / h);
    total_[c.a].force += force;
    total_[c.a].torque += c.r_a.cross(force);
    if (c.b < 0) continue;
    total_[c.b].force -= force;
    total_[c.b].torque -= c.r_b.cross(force);
  }
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
  constexpr double may_stay = 3e3;  // times the touch distance: the next step sees it
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
