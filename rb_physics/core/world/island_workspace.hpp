// Scratch memory of one thread that moves islands: kept from step to step, so that a step after
// warm-up allocates nothing. Holds no state; results never depend on it.
#pragma once

#include <cstdint>
#include <vector>

#include "body/body.hpp"
#include "collision/contact_point.hpp"
#include "contact/contact.hpp"
#include "contact/kinematics.hpp"
#include "contact/problem.hpp"
#include "solver/closing.hpp"
#include "solver/contact_solver.hpp"
#include "world/group_balance.hpp"
#include "world/stats.hpp"

namespace rb {

// Two colliders that may meet during the step; a dynamic body is always first.
struct ColliderPair {
  std::int32_t a = -1;
  std::int32_t b = -1;
};

// Islands of more contact points are moved by wide sweeps in one solve a step, which end before
// they have converged; the residual says how far they came.
inline bool is_large_island(std::size_t contact_points) { return contact_points > 400; }

struct IslandWorkspace {
  ContactProblem problem, settle_problem;
  ContactSolution solution;
  ContactSolution steady;  // without what earlier steps left (carry.cpp)
  SolverWorkspace solver;
  BodyGraph graph;  // of all contacts within reach

  // See IslandAdvance, which names them.
  std::vector<Contact> contacts, departed, found, of_all;
  std::vector<ColliderPair> pairs, covered;
  std::vector<RigidState> start, partner_start;
  std::vector<std::int32_t> partners, slides, active, settled, own;
  std::vector<std::uint8_t> carried, closed;  // per contact
  std::vector<Wrench> total;
  std::vector<Vec3> slip_before, relative_velocity;
  std::vector<double> slip_left, slip_now;
  std::vector<ContactDrift> drifts;
  std::vector<Vec6> shift, velocity_before;
  ContactPoints points;
  std::vector<BodyGain> gains;
  GroupWorkspace groups;
  std::vector<double> gaps;  // m, per contact
  ClosingWorkspace closing;

  // Of all islands this thread moved in the step.
  std::vector<Contact> replaced;  // of islands whose contacts were found again on the way
  bool any_replaced = false;
  Stats stats;
};

}  // namespace rb
