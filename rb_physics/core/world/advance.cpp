#include "world/advance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "body/free_motion.hpp"
#include "body/rk4.hpp"
#include "collision/iteration_caps.hpp"
#include "contact/builder.hpp"
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
  start_.clear();
  total_.clear();
  active_.clear();
  for (std::size_t k = 0; k < rows.size(); ++k)
    world.work.index_of[rows[k]] = static_cast<std::int32_t>(k);
  for (const std::int32_t row : rows) total_.push_back(world.applied[row]);
}

void IslandAdvance::run(double h) {
  const Settings& settings = world_.settings;
  const bool event_stepper = settings.stepper == Stepper::EVENT;
  if (among_others_ || (!event_stepper && is_large_island(contacts.size())))
    return run_in_one_solve(h);
  for (Contact& c : contacts) {
    c.loaded = false;
    c.stuck = c.warm_force.x() > 0.0 && c.sticks_under(c.warm_force);
  }
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
    if (!strike(left)) return take_at_once(h);
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
    double tau = last ? coarse_piece_of(h, left) : piece_of(left);
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
    left -= tau;
    if (!(left > 1e-14 * h)) close_loaded(tau);
    take_back(tau);
    elapsed_ += tau;
    if (!(left > 1e-14 * h)) break;
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

void IslandAdvance::mark() {
  start_.clear();
  for (const std::int32_t row : rows_) start_.push_back(world_.bodies[row].state);
}

void IslandAdvance::move(double tau) {
  relative_known_ = false;
  for (std::size_t k = 0; k < rows_.size(); ++k) move_body(k, tau);
}

namespace {

// A way shorter than a rounding of the body's size, and a turn by less than one of a unit
// quaternion, is none: wherever the world's origin and axes are, as far from them it is.
void keep_still(const RigidState& start, double reach, RigidState& end) {
  constexpr double rounding = std::numeric_limits<double>::epsilon();
  if ((end.x - start.x).cwiseAbs().maxCoeff() <= rounding * reach) end.x = start.x;
  if ((end.q.coeffs() - start.q.coeffs()).cwiseAbs().maxCoeff() <= rounding) end.q = start.q;
}

}  // namespace

void IslandAdvance::move_body(std::size_t k, double tau) {
  const bool rk4 = world_.settings.free_motion == FreeMotion::RK4;
  Body& body = world_.bodies[rows_[k]];
  body.state = rk4 ? rk4_step(start_[k], body.inertia, total_[k], tau)
                   : move_free(start_[k], body.inertia, total_[k], tau);
  if (!shift_.empty()) shift_body(body, shift_[k]);
  keep_still(start_[k], world_.reach[rows_[k]], body.state);
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
