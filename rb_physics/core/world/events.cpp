// The two kinds of instants that split a step: a contact closes (S7's contact time), a slide ends
// in stick.
#include <algorithm>
#include <cmath>
#include <limits>

#include "body/angular_bounds.hpp"
#include "body/free_motion.hpp"
#include "collision/extent.hpp"
#include "collision/iteration_caps.hpp"
#include "collision/queries.hpp"
#include "collision/surface_contacts.hpp"
#include "collision/sweep.hpp"
#include "solver/contact_operators.hpp"
#include "world/advance.hpp"
#include "world/detect.hpp"
#include "world/free_sweep.hpp"
#include "world/kinematic.hpp"

namespace rb {
namespace {

// Balls, and a ball on a plane: what touches has no other feature to come down.
bool has_one_point(const Collider& a, const Collider& b) {
  const auto is_ball = [](const Shape& s) {
    return std::holds_alternative<Sphere>(s) || std::holds_alternative<Particle>(s);
  };
  return is_ball(a.shape) && (is_ball(b.shape) || std::holds_alternative<HalfSpace>(b.shape));
}

}  // namespace

// Of a body at time t, under the present forces.
Pose IslandAdvance::pose_at(std::int32_t row, double t) const {
  const Body& body = world_.bodies[row];
  if (!body.is_dynamic()) return kinematic_pose(body, t);
  const std::int32_t k = world_.work.index_of[row];
  Body moved = {};
  moved.state = move_free(start_[k], body.inertia, total_[k], t);
  moved.center_of_mass = body.center_of_mass;
  return moved.pose();
}

// Smallest separation at time t among the pair's points that do not touch now; +infinity when there
// is none.
double IslandAdvance::approach_of_pair(const ColliderPair& pair, double t) {
  const Collider& a = world_.colliders[pair.a];
  const Collider& b = world_.colliders[pair.b];
  work_.points.clear();
  find_contacts(a.shape, pose_at(a.body, t) * a.local, b.shape, pose_at(b.body, t) * b.local,
                pair_margin(world_, pair), work_.points);
  double nearest = std::numeric_limits<double>::infinity();
  for (const ContactPoint& p : work_.points) {
    const bool touches = std::any_of(contacts.begin(), contacts.end(), [&](const Contact& c) {
      return c.collider_a == pair.a && c.collider_b == pair.b &&
             c.point.feature == with_parts(p.feature, a.part, b.part) && c.touching();
    });
    if (!touches) nearest = std::fmin(nearest, p.separation);
  }
  return nearest;
}

bool IslandAdvance::touches(const ColliderPair& pair) const {
  return std::any_of(contacts.begin(), contacts.end(), [&](const Contact& c) {
    return c.collider_a == pair.a && c.collider_b == pair.b && c.touching();
  });
}

// Only beyond the plane of a face that its body stands on can the pair meet.
bool IslandAdvance::is_covered(const ColliderPair& pair) const {
  return std::any_of(covered.begin(), covered.end(),
                     [&](const ColliderPair& c) { return c.a == pair.a && c.b == pair.b; });
}

// Whether the body of a covered pair that stands on a face will not go beyond the face's plane
// within t. Looks at the ends of short intervals.
bool IslandAdvance::stays_on_plane(const ColliderPair& pair, double t) const {
  constexpr double turn = 0.1;  // rad between two looks
  constexpr double most_looks = 64.0;
  const auto stays = [&](const Contact& c, bool slider_is_b) {
    const Collider& slider = world_.colliders[slider_is_b ? c.collider_b : c.collider_a];
    const std::int32_t floor = slider_is_b ? c.body_a : c.body_b;
    const Pose start = world_.bodies[floor].pose();
    const Vec3 normal = start.rotate_inverse(slider_is_b ? Vec3(-c.point.normal) : c.point.normal);
    const Vec3& on_floor = slider_is_b ? c.local_a : c.local_b;
    const double spin = world_.bodies[slider.body].angular_velocity().norm();
    const double looks = std::fmin(1.0 + std::floor(spin * t / turn), most_looks);
    for (double i = 1.0; i <= looks; i += 1.0) {
      const double at = t * (i / looks);
      const Pose pose = pose_at(floor, at);
      const Vec3 n = pose.rotate(normal);
      const double below = extent(slider.shape, pose_at(slider.body, at) * slider.local, -n);
      if (-below - n.dot(pose.apply(on_floor)) < -2.0 * c.touch) return false;
    }
    return true;
  };
  return std::any_of(contacts.begin(), contacts.end(), [&](const Contact& c) {
    const NormalOwner owner = c.point.normal_owner;
    if (!c.touching() || (owner != NormalOwner::A && owner != NormalOwner::B)) return false;
    for (const std::int32_t slider : {pair.a, pair.b}) {
      const std::int32_t piece = slider == pair.a ? pair.b : pair.a;
      if ((c.collider_a != slider && c.collider_b != slider) || c.collider_a == piece ||
          c.collider_b == piece || !world_.bodies[world_.colliders[slider].body].is_dynamic())
        continue;
      const bool slider_is_b = c.collider_b == slider;
      const Vec3 n = slider_is_b ? Vec3(-c.point.normal) : c.point.normal;
      const Vec3& on_floor = slider_is_b ? c.point.point_a : c.point.point_b;
      const Collider& other = world_.colliders[piece];
      const Pose pose = world_.bodies[other.body].pose() * other.local;
      if (is_surface(other.shape) || extent(other.shape, pose, n) > n.dot(on_floor) + 2.0 * c.touch)
        continue;
      if (stays(c, slider_is_b)) return true;
    }
    return false;
  });
}

// m: how far turning may take the surface of a collider within t, under the present forces.
double IslandAdvance::turning_bound(const Collider& c, double t) const {
  const Body& body = world_.bodies[c.body];
  double reach = world_.reach[c.body];
  if (std::holds_alternative<Sphere>(c.shape) || std::holds_alternative<Particle>(c.shape))
    reach = (c.local.position - body.center_of_mass).norm();
  if (reach == 0.0) return 0.0;
  double spin = body.spin.norm();
  if (body.is_dynamic()) {
    const std::int32_t k = world_.work.index_of[c.body];
    spin = max_angular_speed(start_[k], body.inertia, total_[k].torque.norm(), t);
  }
  // However often a body turns: no point goes farther than across it.
  return std::fmin(t * spin, 2.0) * reach;
}

// m/s^2, of the centre of mass, under the present forces.
Vec3 IslandAdvance::acceleration_of(std::int32_t row) const {
  const Body& body = world_.bodies[row];
  if (!body.is_dynamic()) return Vec3::Zero();
  return body.inertia.inv_mass * total_[world_.work.index_of[row]].force;
}

// m: how much the surfaces of the pair can near each other within t, under the present forces.
double IslandAdvance::closing_bound(const ColliderPair& pair, double t) const {
  const Collider& a = world_.colliders[pair.a];
  const Collider& b = world_.colliders[pair.b];
  const Vec3 apart =
      world_.bodies[a.body].linear_velocity() - world_.bodies[b.body].linear_velocity();
  const double pull = acceleration_of(a.body).norm() + acceleration_of(b.body).norm();
  return t * apart.norm() + turning_bound(a, t) + turning_bound(b, t) + t * t * pull;
}

// Whether a plane across the normal n keeps the two apart for t.
bool IslandAdvance::stays_apart(const ColliderPair& pair, const Vec3& n, double t) const {
  const Collider& a = world_.colliders[pair.a];
  const Collider& b = world_.colliders[pair.b];
  if (is_surface(a.shape) || is_surface(b.shape)) return false;
  const Body& body_a = world_.bodies[a.body];
  const Body& body_b = world_.bodies[b.body];
  const double gap = -extent(a.shape, body_a.pose() * a.local, -n) -
                     extent(b.shape, body_b.pose() * b.local, n) - turning_bound(a, t) -
                     turning_bound(b, t);
  const double speed = n.dot(body_a.linear_velocity() - body_b.linear_velocity());
  const double rate = n.dot(acceleration_of(a.body) - acceleration_of(b.body));
  double least = std::fmin(gap, gap + t * (speed + 0.5 * t * rate));
  if (rate > 0.0 && speed < 0.0 && -speed < t * rate) least = gap - 0.5 * speed * speed / rate;
  return least > touch_distance(std::fmin(a.size, b.size));
}

std::optional<double> IslandAdvance::impact_of_pair(const ColliderPair& pair, double t_max) const {
  const Collider& a = world_.colliders[pair.a];
  const Collider& b = world_.colliders[pair.b];
  double gap = is_covered(pair) ? 0.0 : std::numeric_limits<double>::infinity();
  Vec3 normal = Vec3::Zero();
  for (const Contact& c : contacts) {
    if (c.collider_a != pair.a || c.collider_b != pair.b || !(c.point.separation < gap)) continue;
    gap = c.point.separation;
    normal = c.point.normal;
  }
  if (closing_bound(pair, t_max) < gap) return std::nullopt;
  if (gap > 0.0 && std::isfinite(gap) && stays_apart(pair, normal, t_max)) return std::nullopt;
  const auto sweep_of = [&](std::int32_t row) {
    const Body& body = world_.bodies[row];
    if (!body.is_dynamic()) return FreeSweep(body, body.state, {}, t_max);
    const std::int32_t k = world_.work.index_of[row];
    return FreeSweep(body, start_[k], total_[k], t_max);
  };
  const FreeSweep sweep_a = sweep_of(a.body);
  const FreeSweep sweep_b = sweep_of(b.body);
  // Where one search ran out, the next ones would.
  const int most_queries =
      iteration_caps() > caps_before_ ? usual_distance_queries / 10 : usual_distance_queries;
  return find_time_of_impact(a.shape, PartSweep(sweep_a, a.local), b.shape,
                             PartSweep(sweep_b, b.local), t_max, most_queries)
      .time;
}

// Earliest time in (0, tau) at which the pair meets anew, else tau.
double IslandAdvance::contact_time_of_pair(const ColliderPair& pair, double tau) {
  const double size = std::fmin(world_.colliders[pair.a].size, world_.colliders[pair.b].size);
  const double touch = touch_distance(size);
  if (!touches(pair)) {
    const bool covered_now = is_covered(pair);
    if (covered_now && stays_on_plane(pair, tau)) return tau;
    // Apart: conservative advancement on the true motion, which no thin wall escapes.
    const auto t = impact_of_pair(pair, tau);
    // Side by side with a covered piece is no meeting.
    return t && *t < tau && !(covered_now && *t == 0.0) ? *t : tau;
  }
  const double bound = closing_bound(pair, tau);
  if (bound < touch) return tau;  // at rest
  // Touching already: another feature of the pair may come down. A body that travels far or spins
  // fast may part, strike again and be through a thin wall before the end of the interval.
  if (bound > 0.25 * std::fmin(size, width_between(pair))) {
    const auto strike = impact_of_pair(pair, tau);
    if (strike && *strike < tau) {
      if (*strike > 0.0) return *strike;
      // Closing at once: a point that slides along a curve, or a feature just beyond the touch
      // distance. The others are followed by steps within which nothing can close them.
      constexpr int most_looks = 32;
      double gap = approach_of_pair(pair, 0.0);
      if (gap > 0.0 && std::isfinite(gap)) {
        double t = 0.0;
        for (int look = 0; look < most_looks && t < tau && gap > touch; ++look) {
          t += tau * std::fmax(gap, touch) / bound;
          if (t < tau) gap = approach_of_pair(pair, t);
        }
        return std::fmin(tau, t);
      }
    }
  }
  if (has_one_point(world_.colliders[pair.a], world_.colliders[pair.b])) return tau;
  double high = tau;
  double g_high = approach_of_pair(pair, high);
  if (!(g_high < -touch)) return tau;
  // Regula falsi with the Illinois rule, bisection where the set of points jumps.
  double low = 0.0;
  double g_low = approach_of_pair(pair, low);
  const double goal = 1e-4 * touch;
  int side = 0;
  for (int n = 0; n < 200 && high - low > 4e-16 * tau && std::fabs(g_high) > goal; ++n) {
    double t = 0.5 * (low + high);
    if (n < 100 && std::isfinite(g_low) && g_low > 0.0) {
      const double s = low + (high - low) * g_low / (g_low - g_high);
      if (s > low && s < high) t = s;
    }
    const double g = approach_of_pair(pair, t);
    if (g > goal) {
      low = t;
      g_low = g;
      if (side == 1) g_high *= 0.5;
      side = 1;
    } else {
      high = t;
      g_high = g;
      if (side == -1 && std::isfinite(g_low)) g_low *= 0.5;
      side = -1;
      if (std::fabs(g) <= goal) break;
    }
  }
  return high;
}

// What turns fast on its contact closes it again at once, with hardly any speed: an event each. In
// a hurry such a pair is left alone for so long that it overlaps by next to nothing of its width.
double IslandAdvance::unhurt_until(const ColliderPair& pair, double t, double tau) {
  constexpr double little = 1e-3;
  const Collider& a = world_.colliders[pair.a];
  const Collider& b = world_.colliders[pair.b];
  const double deep = little * std::fmin(a.width + b.width, 2.0 * std::fmin(a.size, b.size));
  double acceleration = 0.0;  // m/s^2, of the surfaces toward each other
  for (const std::int32_t row : {a.body, b.body}) {
    const Body& body = world_.bodies[row];
    const double spin = body.angular_velocity().norm();
    acceleration += spin * spin * world_.reach[row];
    if (!body.is_dynamic()) continue;
    const std::int32_t k = world_.work.index_of[row];
    acceleration += body.inertia.inv_mass * total_[k].force.norm();
  }
  if (!(acceleration > 0.0) || !std::isfinite(acceleration)) return t;
  const double until = std::fmin(std::sqrt(2.0 * deep / acceleration), tau);
  if (!(t < until)) return t;
  work_.points.clear();
  find_contacts(a.shape, pose_at(a.body, until) * a.local, b.shape,
                pose_at(b.body, until) * b.local, 0.0, work_.points);
  const bool hurt = std::any_of(work_.points.begin(), work_.points.end(),
                                [&](const auto& p) { return p.separation < -2.0 * deep; });
  return hurt ? t : until;
}

double IslandAdvance::next_contact_time(double tau) {
  double earliest = tau;
  for (const ColliderPair& pair : pairs) {
    double t = contact_time_of_pair(pair, earliest);
    if (hurried_ && t < earliest) t = unhurt_until(pair, t, earliest);
    if (!(t < earliest)) continue;
    earliest = t;
    met_ = pair;
  }
  return earliest;
}

double IslandAdvance::next_stick_time(double tau) {
  // Larger islands take the error of a stop, of second order in dt.
  const std::size_t most_contacts =
      world_.settings.stepper == Stepper::EVENT
          ? 64
          : static_cast<std::size_t>(std::max(world_.settings.max_event_contacts, 0));
  constexpr double least_share = 1e-3;  // of tau: a stop sooner than that is left unresolved
  if (active_.size() > most_contacts) return tau;
  const IslandWorkspace& work = work_;
  // A slide ends (or turns back) within the interval where the slip at its end is not along the
  // slip before.
  work_.slides.clear();
  double guess = 1.0;  // share of tau at which the first slide stops
  for (std::size_t n = 0; n < active_.size(); ++n) {
    const ContactConstraint& c = work.problem.contacts[n];
    const Vec2 before = slip_before_[n].tail<2>();
    const double slip = before.norm();
    if (!slides(contacts[active_[n]], slip_before_[n])) continue;
    const double brake = inverse_effective_mass(work.problem, c) * c.friction *
                         work.solution.impulse[n].x();  // m/s that friction takes within tau
    if (slip <= least_share * brake || !(brake > 0.0)) continue;
    const Vec2 after = relative_velocity(c, work.solution.velocity).tail<2>();
    if (after.dot(before) > 1e-9 * before.squaredNorm()) continue;
    work_.slides.push_back(static_cast<std::int32_t>(n));
    guess = std::fmin(guess, slip / brake);
  }
  if (work_.slides.empty()) return tau;
  // In an interval short enough to slide all through, the slip shrinks: secants of it, kept between
  // the longest such interval and the shortest other one, until the next one is as good as the end.
  constexpr int most_looks = 24;
  constexpr double near = 2e-3;  // of the slide: there a secant is right to rounding
  double slid_until = 0.0, not_until = tau;
  std::vector<double>& rest = work_.slip_left;  // share of the slip, by slide, at slid_until
  rest.assign(work_.slides.size(), 1.0);
  double t = 0.5 * guess * tau;
  for (int look = 0; look < most_looks; ++look) {
    carry(t, false);
    double zero = std::numeric_limits<double>::infinity();
    bool slid = true;
    work_.slip_now.clear();
    for (std::size_t k = 0; k < work_.slides.size(); ++k) {
      const std::int32_t i = work_.slides[k];
      const Vec2 u0 = slip_before_[i].tail<2>();  // in the frame that this t gives the contact
      const Vec2 u1 = relative_velocity(work.problem.contacts[i], work.solution.velocity).tail<2>();
      const double left = u1.dot(u0) / u0.squaredNorm();
      if (left <= 1e-9) slid = false;
      if (left < rest[k]) zero = std::fmin(zero, t + left * (t - slid_until) / (rest[k] - left));
      work_.slip_now.push_back(left);
    }
    if (!slid) {
      if (t <= least_share * tau) break;
      not_until = t;
      t = slid_until > 0.0 ? 0.5 * (slid_until + not_until) : 0.25 * not_until;
      continue;
    }
    if (!(zero < tau))
      break;  // nothing slows down in short: the slip ends by the end's doing alone
    if (zero - t <= near * zero) {
      carry(tau, false);
      return zero < (1.0 - 1e-12) * tau ? zero : tau;
    }
    slid_until = t;
    rest.swap(work_.slip_now);
    t = 0.999 * zero < not_until ? 0.999 * zero : 0.5 * (slid_until + not_until);
  }
  carry(tau, false);
  return tau;
}

}  // namespace rb
