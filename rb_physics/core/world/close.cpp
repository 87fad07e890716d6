// Contacts that carry force are closed. What turning has made of their gaps within a step, of third
// order in it, is put right at its end by the least displacement, which no momentum sees: contacts
// are then found where they belong.
#include <algorithm>
#include <cmath>

#include "contact/builder.hpp"
#include "solver/closing.hpp"
#include "solver/contact_operators.hpp"
#include "world/advance.hpp"
#include "world/correct.hpp"
#include "world/kinematic.hpp"

namespace rb {

namespace {

constexpr double rounding = 0.01;  // of the touch distance: left alone

bool has_corners(const Shape& shape) {
  return std::holds_alternative<Box>(shape) || std::holds_alternative<ConvexHull>(shape) ||
         std::holds_alternative<HalfSpace>(shape);
}

}  // namespace

bool is_flat(const World& world, const Contact& c) {
  return (c.point.normal_owner == NormalOwner::A || c.point.normal_owner == NormalOwner::B) &&
         has_corners(world.colliders[c.collider_a].shape) &&
         has_corners(world.colliders[c.collider_b].shape);
}

// The contact tau seconds after the state marked last: its points and its normal, a face's, move
// with the bodies.
ContactPlace IslandAdvance::place_after(const Contact& c, double tau, double& gap) const {
  const auto pose_of = [&](std::int32_t row) {
    const Body& body = world_.bodies[row];
    return body.is_dynamic() ? body.pose() : kinematic_pose(body, tau);
  };
  const Pose a = pose_of(c.body_a), b = pose_of(c.body_b);
  const bool of_a = c.point.normal_owner == NormalOwner::A;
  const std::int32_t owner = of_a ? c.body_a : c.body_b;
  const Body& body = world_.bodies[owner];
  const Quat& before = body.is_dynamic() ? start_[world_.work.index_of[owner]].q : body.state.q;
  const Vec3 normal = (of_a ? a : b).orientation * (before.conjugate() * c.point.normal);
  const Vec3 on_a = a.apply(c.local_a), on_b = b.apply(c.local_b);
  gap = normal.dot(on_a - on_b);
  return {0.5 * (on_a + on_b), normal, world_.bodies[c.body_a].state.x,
          b.apply(world_.bodies[c.body_b].center_of_mass)};
}

// Where it is not that simple, correct_positions has another look.
void IslandAdvance::close_loaded(double tau) {
  if (world_.settings.stepper != Stepper::FIXED || !(shift_.empty() || pushed_) || !turning(tau))
    return;
  const auto is_round = [this](const Contact& c) { return c.loaded && !is_flat(world_, c); };
  if (std::any_of(contacts.begin(), contacts.end(), is_round)) return;
  constexpr int most_looks = 3;  // gaps are linearised
  for (int look = 0; look < most_looks && close_once(tau); ++look) {
  }
}

// Adds to `shift_`. Whether anything turned so far that gaps are to be looked at again.
bool IslandAdvance::close_once(double tau) {
  std::vector<std::uint8_t>& closed = work_.closed;
  closed.assign(contacts.size(), 0);
  double widest = 0.0;
  bool open = false;
  static thread_local std::vector<ContactPlace> places;
  places.clear();
  work_.gaps.clear();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& c = contacts[i];
    double gap = 0.0;
    places.push_back(place_after(c, tau, gap));
    const bool flat = is_flat(world_, c);
    if (!flat) gap = c.point.separation;  // a guess: not to be made worse
    work_.gaps.push_back(gap);
    closed[i] = c.loaded || gap < -rounding * c.touch;
    if (!closed[i]) continue;
    if (!flat || !c.touching() || !(std::fabs(gap) <= Contact::most_opened * c.touch)) return false;
    open |= std::fabs(gap) > rounding * c.touch;
    widest = std::fmax(widest, std::fabs(gap));
  }
  if (!open) return false;
  const BodyIndex index{rows_, &world_.work.index_of};
  ContactProblem& problem = work_.settle_problem;
  build_bodies(world_.bodies, index, problem);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    build_contact(world_.bodies, index, contacts[i], places[i], problem);
    problem.contacts.back().bias = Vec3(work_.gaps[i], 0.0, 0.0);
  }
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const double turn = overlap_turn(widest, world_.reach[rows_[k]]);
    problem.inv_inertia[k] =
        harmless_inverse_inertia(world_, rows_[k], problem.inv_inertia[k], turn);
  }
  std::vector<Vec6>& by = work_.velocity_before;
  // What else comes to overlap is kept closed, too.
  constexpr int most_rounds = 4;
  bool good = false;
  for (int round = 0; round < most_rounds && !good; ++round) {
    if (!close_contacts(problem, closed, solver_settings().max_factor_work, work_.solver.space,
                        work_.closing, by))
      return false;
    good = true;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const double left = relative_velocity(problem.contacts[i], by).x();
      const double slack = rounding * contacts[i].touch;
      if (closed[i] ? std::fabs(left) <= slack : left >= -slack) continue;
      if (closed[i]) return false;
      closed[i] = 1;
      good = false;
    }
  }
  if (!good) return false;
  shift_.resize(rows_.size(), Vec6::Zero());
  pushed_ = true;
  double curved = 0.0;  // m, about what the gaps differ from linear ones
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    shift_body(world_.bodies[rows_[k]], by[k]);
    shift_[k] += by[k];
    curved = std::fmax(curved, by[k].tail<3>().squaredNorm() * world_.reach[rows_[k]]);
  }
  return std::any_of(contacts.begin(), contacts.end(), [&](const Contact& c) {
    return c.loaded && curved > 0.1 * rounding * c.touch;
  });
}

}  // namespace rb
