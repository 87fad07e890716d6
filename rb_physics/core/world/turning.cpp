// What turns under the contacts: how long the interval may be because of it, and the contacts as
// they stand in its middle.
#include <algorithm>
#include <cmath>

#include "body/free_motion.hpp"
#include "math/rotation.hpp"
#include "world/advance.hpp"

namespace rb {

namespace {

constexpr std::size_t kFewContacts = 8;

// rad/s: how fast the world's J^-1 changes. A wheel that spins keeps it.
double turning_rate_of_inertia(const Body& body) {
  if (body.inertia.isotropic) return 0.0;
  const Mat3 inverse = world_inverse_inertia(body.state.q, body.inertia);
  const Mat3 turned = skew(body.angular_velocity()) * inverse;
  return (turned + turned.transpose()).norm() / inverse.norm();
}

}  // namespace

// rad/s: how fast the contact's normal and its arms turn, those measured by what they make of an
// impulse: trace W = 3/m + tr J^-1 r^2 - r . J^-1 r. A ball that rolls or spins keeps both.
double IslandAdvance::turning_rate(const Contact& c) const {
  const ContactDrift drift = contact_drift(world_, c);
  const Vec3 point = place_of(world_.bodies, c).point;
  const auto of_arm = [&](const Body& body) {
    const Mat3 inverse = world_inverse_inertia(body.state.q, body.inertia);
    const auto turn = [&](const Vec3& r) {
      return inverse.trace() * r.squaredNorm() - r.dot(inverse * r);
    };
    const Vec3 rate = drift.point_rate - body.linear_velocity();
    return std::sqrt(turn(rate) / (3.0 * body.inertia.inv_mass + turn(point - body.state.x)));
  };
  const Body& a = world_.bodies[c.body_a];
  const Body& b = world_.bodies[c.body_b];
  const double rate = std::fmax(drift.normal_rate.norm(), of_arm(a));
  return b.is_dynamic() ? std::fmax(rate, of_arm(b)) : rate;
}

// The midpoint geometry of a contact is right to second order in the angle it turns by: pieces of
// the interval bound that. Finely, so that rolling without slip keeps its energy to 1e-6 of it at
// any dt; `fixed` spends less on a jam.
double IslandAdvance::piece_of(double left) const {
  const bool fine = world_.settings.stepper == Stepper::EVENT || contacts.size() <= kFewContacts;
  const double most_turn = fine ? 2e-3 : 2e-2;  // rad
  const bool touching =
      std::any_of(contacts.begin(), contacts.end(), [](const Contact& c) { return c.touching(); });
  if (!touching) return left;
  double fastest = 0.0;  // of any kind of turning
  double rate = 0.0;     // of what counts
  for (const std::int32_t row : rows_) {
    const Body& body = world_.bodies[row];
    fastest = std::fmax(fastest, body.angular_velocity().norm());
  }
  for (const std::int32_t row : partners_) {
    fastest = std::fmax(fastest, world_.bodies[row].angular_velocity().norm());
  }
  if (fastest * left > most_turn) {
    for (const std::int32_t row : rows_) {
      rate = std::fmax(rate, turning_rate_of_inertia(world_.bodies[row]));
    }
    for (const Contact& c : contacts) {
      if (c.touching()) rate = std::fmax(rate, turning_rate(c));
    }
  }
  const double most_pieces = world_.settings.stepper == Stepper::EVENT ? 1000.0 : 50.0;
  const double pieces = std::fmin(std::ceil(rate * left / most_turn), most_pieces);
  return pieces > 1.0 ? left / pieces : left;
}

// Where contacts are not looked for on the way: what turns, on other corners and at other places of
// a rim than at the start, overlaps by about the square of its angle.
double IslandAdvance::coarse_piece_of(double h, double left) const {
  constexpr std::size_t many = 64;  // contacts: every piece costs a large solve
  const double most_turn = contacts.size() <= many ? 3e-2 : 0.1;  // rad
  constexpr double most_pieces = 4.0;                             // of a step
  double fastest = 0.0;
  for (const std::int32_t row : rows_)
    fastest = std::fmax(fastest, world_.bodies[row].angular_velocity().norm());
  const double pieces = std::clamp(std::ceil(fastest * h / most_turn), 1.0, most_pieces);
  return left * pieces > 1.5 * h ? h / pieces : left;
}

// Whether anything turns enough within tau for the contacts to move: above rounding of a step.
bool IslandAdvance::turning(double tau) const {
  constexpr double negligible = 1e-9;  // rad
  const auto turns = [&](std::int32_t row) {
    return tau * world_.bodies[row].angular_velocity().norm() > negligible;
  };
  // The arms of bodies that pass each other turn too: a free island's angular momentum tells.
  const auto passes = [&](std::int32_t row) {
    const double travel = tau * (world_.bodies[row].linear_velocity() - reference_).norm();
    return travel > negligible * world_.reach[row];
  };
  return std::any_of(rows_.begin(), rows_.end(), turns) ||
         std::any_of(partners_.begin(), partners_.end(), turns) ||
         (free_ && std::any_of(rows_.begin(), rows_.end(), passes));
}

// The constraints of the active contacts as they stand halfway through tau: arms, normals and
// inertias of the midpoint, and in the bias what the relative velocity gains from the motion of the
// contact itself until the end. Velocity and energy errors then are of second order in tau.
void IslandAdvance::build_midpoint(const BodyIndex& index, double tau) {
  IslandWorkspace& work = work_;
  const double half = 0.5 * tau;
  drifts_.clear();
  for (const std::int32_t i : active_) drifts_.push_back(contact_drift(world_, contacts[i]));
  const auto center = [&](const Body& body) -> Vec3 {
    return body.state.x + half * body.linear_velocity();
  };
  for (std::size_t n = 0; n < active_.size(); ++n) {
    const Contact& c = contacts[active_[n]];
    const ContactDrift& drift = drifts_[n];
    const ContactPlace now = place_of(world_.bodies, c);
    const Vec3 slip =
        relative_velocity(world_.bodies[c.body_a], world_.bodies[c.body_b], now.point);
    const ContactPlace middle{now.point + half * drift.point_rate,
                              (now.normal + half * drift.normal_rate).normalized(),
                              center(world_.bodies[c.body_a]), center(world_.bodies[c.body_b])};
    build_contact(world_.bodies, index, c, middle, work.problem);
    ContactConstraint& k = work.problem.contacts.back();
    k.bias += half * (k.frame * drift.velocity_rate);
    k.bias.x() += half * drift.normal_rate.dot(slip);
  }
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const Body& body = world_.bodies[rows_[k]];
    const Quat q = rotate_free(body.state.q, body.state.L, body.inertia, half);
    work.problem.inv_inertia[k] = world_inverse_inertia(q, body.inertia);
  }
}

}  // namespace rb
