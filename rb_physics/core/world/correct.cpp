// Position correction: pushes overlapping bodies apart by the smallest displacement (in the metric
// of their masses) that separates them. It moves positions only: both momenta stay, to the bit. So
// that the kinetic energy L . J^-1 L / 2 stays as well, a body does not turn about omega x L, the
// one axis along which turning changes it; the last pass moves without turning at all.
#include "world/correct.hpp"

#include <algorithm>
#include <cmath>

#include "contact/builder.hpp"
#include "world/advance.hpp"
#include "world/detect.hpp"
#include "world/sleep.hpp"

namespace rb {
namespace {

constexpr double slack = 0.01;  // of the touch distance: rounding is left alone
constexpr int passes = 4;       // the gaps are linearised: curved ones take another look

bool overlaps(const Contact& c) { return !c.ghost && c.point.separation < -slack * c.touch; }

// Without the part that would change the kinetic energy at constant L.
Vec3 harmless_turn(const World& world, std::int32_t row, const Vec3& turn) {
  constexpr double rounding = 1e-13;  // of the energy of its rotation, or to lift it by its size
  const Body& body = world.bodies[row];
  const Vec3 axis = body.angular_velocity().cross(body.state.L);
  const double length_sq = axis.squaredNorm();
  const double energy = 0.5 * body.angular_velocity().dot(body.state.L) +
                        body.inertia.mass * world.settings.gravity.norm() * world.reach[row];
  const double change = turn.dot(axis);
  const double excess = std::fabs(change) - rounding * energy;
  if (!(excess > 0.0)) return turn;
  return turn - (std::copysign(excess, change) / length_sq) * axis;
}

// Moves the bodies of one island by the solution of: min |d|_M^2 / 2 with J d + s >= 0.
void separate(World& world, const Island& island, std::span<const std::int32_t> contacts) {
  IslandWorkspace& work = world.work.threads[0];
  const auto rows = world.islands.bodies(island);
  for (std::size_t k = 0; k < rows.size(); ++k)
    world.work.index_of[rows[k]] = static_cast<std::int32_t>(k);
  const BodyIndex index{rows, &world.work.index_of};
  ContactProblem& problem = work.problem;
  build_bodies(world.bodies, index, problem);
  for (Vec6& v : problem.velocity) v.setZero();
  for (const std::int32_t i : contacts) {
    const Contact& contact = world.contacts[i];
    if (contact.ghost) continue;
    build_contact(world.bodies, index, contact, place_of(world.bodies, contact), problem);
    ContactConstraint& c = problem.contacts.back();
    c.friction = c.static_friction = c.rolling_friction = c.spinning_friction = 0.0;
    c.bias = Vec3(contact.point.separation, 0.0, 0.0);  // m, in place of m/s
    c.angular_bias.setZero();
  }
  work.solution.impulse.assign(problem.contacts.size(), Vec3::Zero());
  work.solution.moment.clear();
  work.solution.certificate.clear();
  SolverSettings settings;
  settings.tolerance = 1e-9;  // of the overlap: what is left is corrected by the next pass
  settings.max_work = world.settings.max_work;
  solve_contacts(problem, settings, work.solution, work.solver);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    Vec6 displacement = work.solution.velocity[k];
    displacement.tail<3>() = harmless_turn(world, rows[k], displacement.tail<3>());
    shift_body(world.bodies[rows[k]], displacement);
  }
}

}  // namespace

void correct_positions(World& world) {
  for (int pass = 0; pass < passes; ++pass) {
    if (std::none_of(world.contacts.begin(), world.contacts.end(), [&](const Contact& c) {
          return overlaps(c) && !at_rest(world, c.body_a, c.body_b);
        }))
      return;
    std::vector<std::uint8_t>& movable = world.work.movable;
    auto& edges = world.work.edges;
    movable.clear();
    for (const Body& body : world.bodies) movable.push_back(body.is_dynamic());
    edges.clear();
    for (const Contact& c : world.contacts) edges.emplace_back(c.body_a, c.body_b);
    world.islands.build(movable, edges);
    for (const Island& island : world.islands.all()) {
      if (sleeps(world, island)) continue;
      const auto contacts = world.islands.edges(island);
      const bool needed = std::any_of(contacts.begin(), contacts.end(),
                                      [&](std::int32_t i) { return overlaps(world.contacts[i]); });
      if (needed) separate(world, island, contacts);
    }
    ++world.stats.corrections;
    detect_contacts(world);
  }
}

}  // namespace rb
