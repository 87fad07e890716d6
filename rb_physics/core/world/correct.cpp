// Position correction: pushes overlapping bodies apart, and loaded contacts that have opened shut,
// by the smallest displacement (in the metric of their masses) that separates them. It moves
// positions only: both momenta stay, to the bit, but for what keeps the angular momentum of a group
// among itself and its energy from rising (world/group_balance.hpp). So that the kinetic energy
// L . J^-1 L / 2 hardly changes, a body does not turn about omega x L, the one axis along which
// turning changes it.
#include "world/correct.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "contact/builder.hpp"
#include "solver/closing.hpp"
#include "solver/contact_operators.hpp"
#include "solver/separation.hpp"
#include "world/advance.hpp"
#include "world/detect.hpp"
#include "world/group_balance.hpp"
#include "world/neighbourhood.hpp"
#include "world/sleep.hpp"
#include "world/step.hpp"

namespace rb {

Mat3 harmless_inverse_inertia(const World& world, std::int32_t row, const Mat3& inverse,
                              double turn) {
  constexpr double rounding = 1e-13;  // of the energy of its rotation, or to lift it by its size
  const Body& body = world.bodies[row];
  const Vec3 axis = body.angular_velocity().cross(body.state.L);
  const double length = axis.norm();
  if (length == 0.0) return inverse;
  const double energy = 0.5 * body.angular_velocity().dot(body.state.L) +
                        body.inertia.mass * world.settings.gravity.norm() * world.reach[row];
  if (turn * length <= rounding * energy) return inverse;
  const Mat3 keep = Mat3::Identity() - axis * axis.transpose() / (length * length);
  return keep * inverse * keep;
}

namespace {

constexpr double slack = 0.01;  // of the touch distance: rounding is left alone
constexpr int passes = 8;       // the gaps are linearised: curved ones take another look

// Times the touch distance: large islands are put right once in every step (world/one_solve.cpp),
// and what turning makes of that, up to 1e-3 of the size of the smaller body, is left to the next
// one.
constexpr double large_slack = 1e6;
constexpr int large_passes = 1;  // a heap that moves has other overlaps in the next step

bool overlaps(const Contact& c, double most) {
  return c.active() && c.point.separation < -most * c.touch;
}

// Left alone, the next step would begin with a contact that is closed by its force only.
bool has_opened(const Contact& c) { return c.active() && c.has_opened(); }

// Whether the work that a displacement does against the forces on a body is taken from its motion.
enum class Lift {
  kCounts,        // all of it: it is what sinking too far has given them
  kCountsInStep,  // as far as the step as a whole has gained energy: jams sink and are lifted
                  // always
};

// What a body has gained since the step began: kinetic energy less the work of outer forces, as
// seen from the frame that moves with `reference`, and the impulse of its contacts.
BodyGain gained_in_step(const World& world, std::int32_t row, const Vec3& reference) {
  const Body& body = world.bodies[row];
  const RigidState& start = world.last_good[row];
  const Wrench& outside = world.applied[row];
  const Vec3 spin = angular_velocity(start, body.inertia);
  const double h = world.settings.dt;
  BodyGain gain;
  gain.impulse = body.state.p - start.p - h * outside.force;
  gain.energy = 0.5 * body.inertia.inv_mass * (body.state.p.squaredNorm() - start.p.squaredNorm()) +
                0.5 * (body.state.L.dot(body.angular_velocity()) - start.L.dot(spin)) -
                outside.force.dot(body.state.x - start.x) -
                0.5 * h * outside.torque.dot(spin + body.angular_velocity()) -
                reference.dot(gain.impulse);
  return gain;
}

// A body that goes farther than it was looked around comes to overlap what is no contact yet, and
// is pushed back by it alone in the next pass: from then on both are to be seen.
void look_farther(World& world, std::int32_t row, const Vec6& by) {
  const double way = by.head<3>().norm() + world.reach[row] * by.tail<3>().norm();
  if (way > world.travel[row] + world.settings.contact_margin)
    world.extra_travel[row] = std::fmax(world.extra_travel[row], way);
}

// Moves the bodies of an island, and takes back what that did to their energy and, where nothing
// immovable takes it up, to x x p. `pushes` are of each active contact; empty: all of them pushed.
void displace(World& world, std::span<const std::int32_t> rows,
              std::span<const std::int32_t> contacts, const std::vector<Vec6>& by,
              const std::vector<Vec3>& pushes, Lift lift) {
  IslandWorkspace& work = world.work.threads[0];
  std::vector<std::int32_t>& links = work.settled;
  links.clear();
  std::size_t n = 0;
  for (const std::int32_t i : contacts) {
    if (!world.contacts[i].active()) continue;
    if (pushes.empty() || !pushes[n].isZero(0.0)) links.push_back(i);
    ++n;
  }
  const Vec3 reference = world.bodies[rows.front()].linear_velocity();
  work.gains.assign(rows.size(), {});
  for (std::size_t k = 0; k < rows.size(); ++k) {
    Body& body = world.bodies[rows[k]];
    const double before = body.state.L.dot(body.angular_velocity());
    shift_body(body, by[k]);
    look_farther(world, rows[k], by[k]);
    work.gains[k].energy = 0.5 * (body.state.L.dot(body.angular_velocity()) - before);
    if (lift == Lift::kCounts)
      work.gains[k].energy -= world.applied[rows[k]].force.dot(by[k].head<3>());
    if (lift == Lift::kCountsInStep) work.gains[k] = gained_in_step(world, rows[k], reference);
    work.gains[k].angular =
        by[k].head<3>().cross(body.inertia.mass * (body.linear_velocity() - reference));
  }
  take_back_gains(world, rows, world.contacts, links, work.gains, reference, work.groups);
}

// Overlaps of a large island that are too deep are few and far between: the bodies about them move,
// all others stay where they are. False where that is not so, or where nothing immovable takes up
// what the others then seem to hold.
bool separate_locally(World& world, const Island& island, std::span<const std::int32_t> contacts) {
  constexpr int most_sweeps = 40;
  constexpr double most_bodies = 0.5;  // of the island: then all of it costs hardly more
  StepWorkspace& step = world.work;
  IslandWorkspace& work = step.threads[0];
  const auto rows = world.islands.bodies(island);
  const auto is_deep = [](const Contact& c) { return overlaps(c, large_slack); };
  const bool held = std::any_of(contacts.begin(), contacts.end(), [&](std::int32_t i) {
    const Contact& c = world.contacts[i];
    return c.active() && !world.bodies[c.body_b].is_dynamic();
  });
  if (!held) return false;
  find_neighbourhood(world, contacts, is_deep, step.near_rows, step.near_contacts);
  const std::vector<std::int32_t>& near = step.near_rows;
  if (!(static_cast<double>(near.size()) <= most_bodies * static_cast<double>(rows.size())))
    return false;

  for (const std::int32_t row : rows) step.index_of[row] = -1;
  for (std::size_t k = 0; k < near.size(); ++k)
    step.index_of[near[k]] = static_cast<std::int32_t>(k);
  const BodyIndex index{near, &step.index_of};
  ContactProblem& problem = work.problem;
  build_bodies(world.bodies, index, problem);
  double deepest = 0.0;  // m
  for (const std::int32_t i : step.near_contacts) {
    const Contact& c = world.contacts[i];
    deepest = std::fmax(deepest, -c.point.separation);
    ContactPlace place = place_of(world.bodies, c);
    Contact ends;
    ends.body_a = c.body_a, ends.body_b = c.body_b;
    if (step.index_of[c.body_a] < 0) {
      std::swap(ends.body_a, ends.body_b);
      std::swap(place.center_a, place.center_b);
      place.normal = -place.normal;
    }
    ends.material.friction = ends.material.static_friction = 0.0;
    build_contact(world.bodies, index, ends, place, problem);
    problem.contacts.back().bias = Vec3(c.point.separation, 0.0, 0.0);  // m, in place of m/s
  }
  for (std::size_t k = 0; k < near.size(); ++k) {
    problem.velocity[k].setZero();
    const double turn = overlap_turn(deepest, world.reach[near[k]]);
    problem.inv_inertia[k] = harmless_inverse_inertia(world, near[k], problem.inv_inertia[k], turn);
  }
  WideContacts& wide = work.solver.wide;
  wide.use(&step.crew);
  wide.forget();
  separate_bodies(problem, 0.01 * deepest, most_sweeps, wide, work.velocity_before);
  wide.use(nullptr);

  work.shift.assign(rows.size(), Vec6::Zero());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::int32_t n = step.index_of[rows[k]];
    if (n < 0) continue;
    work.shift[k] = work.velocity_before[n];
  }
  for (std::size_t k = 0; k < rows.size(); ++k)
    step.index_of[rows[k]] = static_cast<std::int32_t>(k);
  displace(world, rows, contacts, work.shift, {}, Lift::kCountsInStep);
  return true;
}

// Whether displacements are no more than it takes to close gaps (m).
bool is_near(const World& world, std::span<const std::int32_t> rows, const std::vector<Vec6>& by,
             double gap) {
  constexpr double farthest = 100.0;  // gaps: a wedge's
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double way = by[k].head<3>().norm() + world.reach[rows[k]] * by[k].tail<3>().norm();
    if (!(way <= farthest * gap)) return false;
  }
  return true;
}

// Whether that is what they do.
bool separates(const ContactProblem& problem, const std::vector<Vec6>& by, double gap) {
  constexpr double most_left = 1e-3;  // of the gap: next to nothing of what is solved for
  return std::all_of(
      problem.contacts.begin(), problem.contacts.end(),
      [&](const ContactConstraint& c) { return relative_velocity(c, by).x() >= -most_left * gap; });
}

// Gaps are linear in displacements: what turns so far that they are not is made harder to turn, and
// moves instead. True if there was such a body.
bool stiffen_turning(const World& world, std::span<const std::int32_t> rows,
                     const std::vector<Vec6>& by, double gap, ContactProblem& problem) {
  constexpr double curved = 0.1;  // of the gap
  bool any = false;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double sagitta = by[k].tail<3>().squaredNorm() * world.reach[rows[k]];
    if (!(sagitta > curved * gap)) continue;
    problem.inv_inertia[k] *= 0.25 * curved * gap / sagitta;
    any = true;
  }
  return any;
}

// Overlap only, and what sweeps make of it. The problem is the thread's.
void separate_by_sweeps(World& world, std::span<const std::int32_t> rows,
                        std::span<const std::int32_t> contacts, double deepest) {
  IslandWorkspace& work = world.work.threads[0];
  WideContacts& wide = work.solver.wide;
  const bool large = is_large_island(work.problem.contacts.size());
  // What is light between two that are heavy takes many.
  const int most_sweeps = large ? 40 : 400;
  if (large) wide.use(&world.work.crew);
  wide.forget();
  constexpr int most_rounds = 4;
  for (int round = 0; round < most_rounds; ++round) {
    separate_bodies(work.problem, 0.01 * deepest, most_sweeps, wide, work.velocity_before);
    if (large || !stiffen_turning(world, rows, work.velocity_before, deepest, work.problem)) break;
  }
  wide.use(nullptr);
  if (is_near(world, rows, work.velocity_before, deepest))
    displace(world, rows, contacts, work.velocity_before, {}, Lift::kCountsInStep);
}

// A jam that comes to rest has its loaded contacts closed from both sides, if they do not
// contradict each other. What else comes to overlap is kept closed, too. The problem is the
// thread's.
bool close_loaded_ones(World& world, std::span<const std::int32_t> rows,
                       std::span<const std::int32_t> contacts, double deepest) {
  constexpr int most_rounds = 3;
  constexpr double most_left = 1e-3;  // of the gap
  constexpr double most_gap = 1e3;    // touch distances
  IslandWorkspace& work = world.work.threads[0];
  ContactProblem& problem = work.problem;
  std::vector<std::uint8_t>& closed = work.closed;
  closed.clear();
  for (const std::int32_t i : contacts) {
    const Contact& c = world.contacts[i];
    if (!c.active()) continue;
    if (deepest > most_gap * c.touch) return false;
    closed.push_back(c.loaded || overlaps(c, slack));
  }
  for (int round = 0; round < most_rounds; ++round) {
    if (!close_contacts(problem, closed, SolverSettings{}.max_factor_work, work.solver.space,
                        work.closing, work.velocity_before))
      return false;
    bool good = true;
    for (std::size_t n = 0; n < closed.size(); ++n) {
      const double left = relative_velocity(problem.contacts[n], work.velocity_before).x();
      if (closed[n] ? std::fabs(left) <= most_left * deepest : left >= -most_left * deepest)
        continue;
      if (closed[n]) return false;
      closed[n] = 1;
      good = false;
    }
    if (!good) continue;
    if (!is_near(world, rows, work.velocity_before, deepest)) return false;
    displace(world, rows, contacts, work.velocity_before, {}, Lift::kCountsInStep);
    return true;
  }
  return false;
}

// Moves the bodies of one island by the solution of: min |d|_M^2 / 2 with J d + s >= 0, and = 0
// where a loaded contact has opened.
void separate(World& world, const Island& island, std::span<const std::int32_t> contacts) {
  IslandWorkspace& work = world.work.threads[0];
  const auto rows = world.islands.bodies(island);
  for (std::size_t k = 0; k < rows.size(); ++k)
    world.work.index_of[rows[k]] = static_cast<std::int32_t>(k);
  const BodyIndex index{rows, &world.work.index_of};
  ContactProblem& problem = work.problem;
  build_bodies(world.bodies, index, problem);
  for (Vec6& v : problem.velocity) v.setZero();
  double deepest = 0.0;  // or the widest gap that is to be closed
  for (const std::int32_t i : contacts) {
    const Contact& c = world.contacts[i];
    if (!c.active()) continue;
    deepest = std::fmax(deepest, has_opened(c) ? c.point.separation : -c.point.separation);
  }
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double turn = overlap_turn(deepest, world.reach[rows[k]]);
    problem.inv_inertia[k] = harmless_inverse_inertia(world, rows[k], problem.inv_inertia[k], turn);
  }
  const auto constrain = [&](const Contact& contact, const ContactPlace& place, double gap) {
    build_contact(world.bodies, index, contact, place, problem);
    ContactConstraint& c = problem.contacts.back();
    c.friction = c.static_friction = c.rolling_friction = c.spinning_friction = 0.0;
    c.bias = Vec3(gap, 0.0, 0.0);  // m, in place of m/s
    c.angular_bias.setZero();
  };
  for (const std::int32_t i : contacts) {
    const Contact& c = world.contacts[i];
    if (c.active()) constrain(c, place_of(world.bodies, c), c.point.separation);
  }
  const std::size_t one_way = problem.contacts.size();
  // In a jam, what is loaded may not all be closed at once: contacts depend on each other.
  const bool many =
      is_large_island(one_way) ||
      (work.graph.analyze(problem, SolverSettings{}.max_factor_work) && work.graph.is_jam());
  if (!many) {
    for (const std::int32_t i : contacts) {
      const Contact& c = world.contacts[i];
      if (!has_opened(c)) continue;
      ContactPlace place = place_of(world.bodies, c);
      place.normal = -place.normal;
      constrain(c, place, -c.point.separation);
    }
  }
  if (many) {
    if (!is_large_island(one_way) && close_loaded_ones(world, rows, contacts, deepest)) return;
    return separate_by_sweeps(world, rows, contacts, deepest);
  }
  work.solution.impulse.assign(problem.contacts.size(), Vec3::Zero());
  work.solution.moment.clear();
  work.solution.certificate.clear();
  work.solution.vain_searches = 0;
  SolverSettings settings;
  // Of the overlap: what is left is corrected by the next pass. The displacement is unique, the
  // impulses need not be.
  settings.tolerance = settings.enough = 1e-4;
  settings.newton_goal = 1e-12;
  settings.minimum_norm = false;
  settings.max_work = world.settings.max_work;
  solve_contacts(problem, settings, work.solution, work.solver);
  // Loaded contacts that contradict each other are closed by going far away, if at all.
  const std::vector<Vec6>& by = work.solution.velocity;
  if (!is_near(world, rows, by, deepest) || !separates(problem, by, deepest)) {
    problem.contacts.resize(one_way);
    return separate_by_sweeps(world, rows, contacts, deepest);
  }
  std::size_t n = 0, back = one_way;
  for (const std::int32_t i : contacts) {
    const Contact& c = world.contacts[i];
    if (has_opened(c)) work.solution.impulse[n].x() -= work.solution.impulse[back++].x();
    n += c.active();
  }
  displace(world, rows, contacts, by, work.solution.impulse, Lift::kCounts);
}

}  // namespace

void correct_positions(World& world) {
  for (int pass = 0; pass < passes; ++pass) {
    const bool open = any_contact(world, [&](const Contact& c) {
      return (overlaps(c, slack) || (pass == 0 && has_opened(c))) &&
             !at_rest(world, c.body_a, c.body_b);
    });
    if (!open) return;
    std::vector<std::uint8_t>& movable = world.work.movable;
    auto& edges = world.work.edges;
    movable.clear();
    for (const Body& body : world.bodies) movable.push_back(body.is_dynamic());
    edges.resize(world.contacts.size());
    world.work.crew.share_range(edges.size(), 512, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        edges[i] = {world.contacts[i].body_a, world.contacts[i].body_b};
    });
    world.islands.build(movable, edges);
    bool any = false;
    for (const Island& island : world.islands.all()) {
      if (sleeps(world, island)) continue;
      const auto contacts = world.islands.edges(island);
      const bool large = is_large_island(contacts.size());
      const bool needed = std::any_of(contacts.begin(), contacts.end(), [&](std::int32_t i) {
        const Contact& c = world.contacts[i];
        if (large) return pass < large_passes && overlaps(c, large_slack);
        return overlaps(c, slack) || (pass == 0 && has_opened(c));
      });
      if (!needed) continue;
      any = true;
      if (!large || !separate_locally(world, island, contacts)) separate(world, island, contacts);
    }
    if (!any) return;
    ++world.stats.corrections;
    detect_contacts(world);
  }
}

}  // namespace rb
