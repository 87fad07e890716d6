// Find-intersection for the whole world (S7, S8): broad phase, narrow phase, and the match of each
// point with its predecessor by feature id, which carries the force on from step to step.
#include "world/detect.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <variant>

#include "body/angular_bounds.hpp"
#include "collision/iteration_caps.hpp"
#include "collision/queries.hpp"
#include "contact/builder.hpp"
#include "world/seams.hpp"
#include "world/sleep.hpp"
#include "world/step.hpp"

namespace rb {
namespace {

constexpr std::size_t kFewBodies = 64;  // not worth another thread

using ColliderKey = std::pair<std::int32_t, std::int32_t>;

ColliderKey key_of(const Contact& c) { return {c.collider_a, c.collider_b}; }

// m a body's surface may move in one step on top of its linear velocity: acceleration and rotation.
double travel_of(const World& world, std::int32_t row, double slack) {
  const Body& body = world.bodies[row];
  const double h = world.settings.dt;
  double linear = 0.0;
  double angular = body.angular_velocity().norm();
  if (body.is_dynamic()) {
    const Wrench& w = world.applied[row];
    linear = slack * h * h * body.inertia.inv_mass * w.force.norm();
    angular = max_angular_speed(body.state, body.inertia, slack * w.torque.norm(), h);
  }
  // However often a body turns: no point goes farther than across it.
  return linear + std::fmin(h * angular, 2.0) * world.reach[row] + world.extra_travel[row];
}

// To eight bits, by less than a hundredth: so that bodies that rest, whose velocities are rounding,
// are seen with the same margin from step to step.
double rounded_up(double positive) {
  constexpr std::uint64_t rest = (std::uint64_t{1} << 45) - 1;
  const double up = std::bit_cast<double>((std::bit_cast<std::uint64_t>(positive) + rest) & ~rest);
  return std::isfinite(up) ? up : positive;
}

void move_proxies(World& world) {
  const double h = world.settings.dt;
  // Each with its way in the step, if that is more than a trifle of the room around it.
  constexpr double trifle = 1.0 / 256.0;
  std::vector<ProxyBox>& boxes = world.work.boxes;
  boxes.resize(world.colliders.size());
  const auto stays = [&](const Collider& c) {
    return world.bodies[c.body].type == BodyType::STATIC && !world.geometry_dirty;
  };
  world.work.crew.share_range(boxes.size(), kFewBodies, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Collider& c = world.colliders[k];
      if (stays(c) || std::holds_alternative<HalfSpace>(c.shape)) continue;
      ProxyBox& p = boxes[k];
      p.way = h * world.bodies[c.body].linear_velocity();
      double room =
          world.travel[c.body] + world.settings.contact_margin + 2.0 * touch_distance(c.size);
      const double length = p.way.cwiseAbs().maxCoeff();
      if (length <= trifle * room) {
        room = rounded_up(room + length);
        p.way.setZero();
      }
      p.same = world.work.persistent.stayed(c.body) && p.room == room && p.way.isZero(0.0);
      if (p.same) continue;
      p.room = p.way.isZero(0.0) ? room : std::numeric_limits<double>::quiet_NaN();
      p.box = bounding_box(c.shape, world.bodies[c.body].pose() * c.local);
      p.box.lower.array() -= room;
      p.box.upper.array() += room;
    }
  });
  for (std::size_t k = 0; k < world.colliders.size(); ++k) {
    const Collider& c = world.colliders[k];
    const Body& body = world.bodies[c.body];
    if (stays(c)) continue;
    if (const auto* plane = std::get_if<HalfSpace>(&c.shape)) {
      const Pose pose = body.pose() * c.local;
      const Vec3 n = pose.rotate(plane->normal);
      // A plane that turns may reach any body; pair_margin says which it can.
      const double sweep = body.angular_velocity().isZero(0.0)
                               ? std::fmax(0.0, h * n.dot(body.linear_velocity()))
                               : std::numeric_limits<double>::max();
      world.broad_phase.move_half_space(static_cast<int>(k), n,
                                        plane->offset + n.dot(pose.position) + sweep);
      continue;
    }
    if (!boxes[k].same) world.broad_phase.move(static_cast<int>(k), boxes[k].box, boxes[k].way);
  }
}

// A dynamic body comes first; of two dynamic ones the higher row (design: body_b is the immovable
// one).
bool order_pair(const World& world, std::int32_t& a, std::int32_t& b) {
  const std::int32_t row_a = world.colliders[a].body;
  const std::int32_t row_b = world.colliders[b].body;
  if (row_a == row_b) return false;
  const bool dynamic_a = world.bodies[row_a].is_dynamic();
  const bool dynamic_b = world.bodies[row_b].is_dynamic();
  if (dynamic_a && dynamic_b ? row_a < row_b : !dynamic_a) std::swap(a, b);
  return dynamic_a || dynamic_b;
}

}  // namespace

double pair_margin(const World& world, const ColliderPair& pair) {
  const std::int32_t a = world.colliders[pair.a].body;
  const std::int32_t b = world.colliders[pair.b].body;
  double closing = (world.bodies[a].linear_velocity() - world.bodies[b].linear_velocity()).norm();
  if (std::holds_alternative<HalfSpace>(world.colliders[pair.b].shape)) {
    // The surface of a turning plane is as far from its origin as the body it meets.
    const double arm = (world.bodies[a].state.x - world.bodies[b].state.x).norm() + world.reach[a];
    closing += world.bodies[b].angular_velocity().norm() * arm;
  }
  const double touch =
      touch_distance(std::fmin(world.colliders[pair.a].size, world.colliders[pair.b].size));
  return rounded_up(world.settings.dt * closing + world.travel[a] + world.travel[b] +
                    world.settings.contact_margin + 2.0 * touch);
}

void append_contacts(const World& world, const ColliderPair& pair, double margin,
                     ContactPoints& scratch, std::vector<Contact>& out) {
  const Collider& ca = world.colliders[pair.a];
  const Collider& cb = world.colliders[pair.b];
  const Body& a = world.bodies[ca.body];
  const Body& b = world.bodies[cb.body];
  const double reach = ca.reach + cb.reach + margin;
  if ((a.state.x - b.state.x).squaredNorm() > reach * reach) return;  // nowhere so near
  const Pose pose_a = a.pose();
  const Pose pose_b = b.pose();
  scratch.clear();
  find_contacts(ca.shape, pose_a * ca.local, cb.shape, pose_b * cb.local, margin, scratch);
  if (scratch.empty()) return;
  const Material material = combine(a.material, b.material, world.settings.friction_combine,
                                    world.settings.restitution_combine);
  const double touch = touch_distance(std::fmin(ca.size, cb.size));
  for (const ContactPoint& p : scratch) {
    Contact& c = out.emplace_back();
    c.body_a = ca.body;
    c.body_b = cb.body;
    c.collider_a = pair.a;
    c.collider_b = pair.b;
    c.point = p;
    c.point.feature = with_parts(p.feature, ca.part, cb.part);
    c.local_a = pose_a.apply_inverse(p.point_a);
    c.local_b = pose_b.apply_inverse(p.point_b);
    c.material = material;
    c.touch = touch;
  }
}

void carry_over(std::span<const Contact> old, std::span<Contact> fresh,
                std::vector<Contact>* departed) {
  // Both lists are ordered by pair; within a pair features are matched by id.
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < old.size()) {
    while (j < fresh.size() && key_of(fresh[j]) < key_of(old[i])) ++j;
    std::size_t end = j;
    while (end < fresh.size() && key_of(fresh[end]) == key_of(old[i])) ++end;
    const auto pair_key = key_of(old[i]);
    for (; i < old.size() && key_of(old[i]) == pair_key; ++i) {
      bool matched = false;
      for (std::size_t k = j; k < end && !matched; ++k) {
        Contact& c = fresh[k];
        if (c.point.feature != old[i].point.feature) continue;
        // A point that parted and came back within the step stands in the list twice: its impulses
        // add up.
        c.impulse += old[i].impulse;
        c.moment_a += old[i].moment_a;
        c.moment_b += old[i].moment_b;
        if (old[i].role != ContactRole::GHOST) {
          c.warm_force = old[i].warm_force;
          c.warm_moment = old[i].warm_moment;
          c.loaded = old[i].loaded;
          c.stuck = old[i].stuck;
        }
        matched = true;
      }
      if (!matched && departed && !old[i].impulse.isZero(0.0)) {
        departed->push_back(old[i]);
        departed->back().role = ContactRole::GHOST;
      }
    }
    j = end;
  }
}

void follow_bodies(const World& world, Contact& c) {
  c.point.point_a = world.bodies[c.body_a].pose().apply(c.local_a);
  c.point.point_b = world.bodies[c.body_b].pose().apply(c.local_b);
  c.point.separation = c.point.normal.dot(c.point.point_a - c.point.point_b);
}

namespace {

// The pairs of the broad phase in the order of (A, B). They come in that of (lower, higher): put
// with their A, one after the other, they are sorted.
void sort_pairs(World& world) {
  const auto& found = world.broad_phase.update_pairs();
  std::vector<std::int32_t>& next = world.work.next_pair;
  next.assign(world.colliders.size() + 1, 0);
  const auto ordered = [&](ColliderPair& pair) { return order_pair(world, pair.a, pair.b); };
  for (const auto& [i, j] : found) {
    ColliderPair pair{i, j};
    if (ordered(pair)) ++next[pair.a + 1];
  }
  for (std::size_t k = 1; k < next.size(); ++k) next[k] += next[k - 1];
  world.pairs.resize(next.back());
  for (const auto& [i, j] : found) {
    ColliderPair pair{i, j};
    if (ordered(pair)) world.pairs[next[pair.a]++] = pair;
  }
}

}  // namespace

void find_pairs(World& world) {
  constexpr double slack =
      1.5;  // room for wrenches that change before the next step: no second search
  world.work.crew.share_range(
      world.bodies.size(), kFewBodies, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row)
          world.travel[row] = travel_of(world, static_cast<std::int32_t>(row), slack);
      });
  move_proxies(world);
  sort_pairs(world);
  world.stats.pairs = static_cast<int>(world.pairs.size());
}

namespace {

// Between bodies at rest nothing is new: the contacts as they were, for carry_over to complete.
void append_known(const World& world, const ColliderPair& pair, std::vector<Contact>& out) {
  const auto before = [](const Contact& c, const ColliderPair& p) {
    return std::pair(c.collider_a, c.collider_b) < std::pair(p.a, p.b);
  };
  for (auto c = std::lower_bound(world.contacts.begin(), world.contacts.end(), pair, before);
       c != world.contacts.end() && c->collider_a == pair.a && c->collider_b == pair.b; ++c) {
    if (c->role == ContactRole::GHOST) continue;
    out.push_back(*c);
    out.back().impulse = out.back().moment_a = out.back().moment_b = Vec3::Zero();
  }
}

// The contacts of pair k as they were, impulses and all.
void append_kept(std::span<const Contact> old, std::vector<Contact>& out) {
  for (const Contact& c : old) {
    out.push_back(c);
    // As if they were added to those of a new one, to the sign of a zero.
    Contact& kept = out.back();
    kept.impulse += Vec3::Zero();
    kept.moment_a += Vec3::Zero();
    kept.moment_b += Vec3::Zero();
  }
}

// Appends the contacts of pairs `first` to `last`, with what their features carried before; `old`
// are the contacts that these pairs had, and of pairs between them.
void append_pairs(World& world, std::size_t first, std::size_t last, std::span<const Contact> old,
                  ContactPoints& points, std::vector<Contact>& out,
                  std::vector<Contact>& departed) {
  PersistentManifolds& persistent = world.work.persistent;
  std::size_t open_old = 0, open_new = out.size();  // from here on nothing is carried over yet
  std::size_t at = 0;
  for (std::size_t k = first; k < last; ++k) {
    const ColliderPair& pair = world.pairs[k];
    if (at_rest(world, world.colliders[pair.a].body, world.colliders[pair.b].body)) {
      append_known(world, pair, out);
      persistent.set_margin(k, std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    const double margin = pair_margin(world, pair);
    if (persistent.keeps(world, k, margin)) {
      const ColliderKey key(pair.a, pair.b);
      while (at < old.size() && key_of(old[at]) < key) ++at;
      const std::size_t begin = at;
      while (at < old.size() && key_of(old[at]) == key) ++at;
      const auto known = old.subspan(begin, at - begin);
      if (PersistentManifolds::as_found(known)) {
        carry_over(old.subspan(open_old, begin - open_old), std::span(out).subspan(open_new),
                   &departed);
        append_kept(known, out);
        persistent.set_margin(k, margin);
        open_old = at;
        open_new = out.size();
        continue;
      }
    }
    const std::size_t begin = out.size();
    const std::int64_t caps = iteration_caps();
    append_contacts(world, pair, margin, points, out);
    persistent.looked_at(k, margin, std::span(out).subspan(begin), iteration_caps() > caps);
  }
  carry_over(old.subspan(open_old), std::span(out).subspan(open_new), &departed);
}

// Contacts of the world that belong to pairs from `first` on.
std::size_t place_of_pair(const World& world, const ColliderPair& first) {
  const auto before = [](const Contact& c, const ColliderPair& p) {
    return key_of(c) < ColliderKey(p.a, p.b);
  };
  return static_cast<std::size_t>(
      std::lower_bound(world.contacts.begin(), world.contacts.end(), first, before) -
      world.contacts.begin());
}

// Narrow phase of all pairs, with what their features carried before; blocks of pairs are shared.
void find_all_contacts(World& world, std::vector<Contact>& fresh, std::vector<Contact>& departed) {
  constexpr std::size_t block = 32;
  const std::size_t count = world.pairs.size();
  StepWorkspace& work = world.work;
  if (!work.crew.helped() || count <= block) {
    const IterationCapCounter caps(world.stats.queries_capped);
    fresh.clear();
    append_pairs(world, 0, count, world.contacts, work.threads[0].points, fresh, departed);
    return;
  }
  const auto blocks = static_cast<std::int32_t>((count + block - 1) / block);
  if (work.found.size() < static_cast<std::size_t>(blocks)) work.found.resize(blocks);
  static thread_local std::vector<int> met_caps;
  met_caps.assign(work.threads.size(), 0);
  std::vector<int>& capped = met_caps;  // of this thread
  const auto old_begin = [&](std::size_t pair) {
    return pair == 0       ? 0
           : pair >= count ? world.contacts.size()
                           : place_of_pair(world, world.pairs[pair]);
  };
  work.crew.share(blocks, [&](int worker, std::int32_t b) {
    const IterationCapCounter caps(capped[worker]);
    const std::size_t first = static_cast<std::size_t>(b) * block;
    const std::size_t last = std::min(count, first + block);
    FoundContacts& found = work.found[b];
    found.contacts.clear();
    found.departed.clear();
    const std::size_t old = old_begin(first);
    append_pairs(world, first, last,
                 std::span<const Contact>(world.contacts).subspan(old, old_begin(last) - old),
                 work.threads[worker].points, found.contacts, found.departed);
  });
  for (const int met : capped) world.stats.queries_capped += met;
  std::size_t total = 0;
  for (std::int32_t b = 0; b < blocks; ++b) {
    work.found[b].first = total;
    total += work.found[b].contacts.size();
    departed.insert(departed.end(), work.found[b].departed.begin(), work.found[b].departed.end());
  }
  fresh.resize(total);
  work.crew.share(blocks, [&](int, std::int32_t b) {
    const FoundContacts& found = work.found[b];
    std::copy(found.contacts.begin(), found.contacts.end(),
              fresh.begin() + static_cast<std::ptrdiff_t>(found.first));
  });
}

}  // namespace

void detect_contacts(World& world) {
  PersistentManifolds& persistent = world.work.persistent;
  persistent.begin(world);
  find_pairs(world);
  if (persistent.keeps_all(world)) {
    share_contacts(world, [](Contact& c) {
      c.impulse += Vec3::Zero();
      c.moment_a += Vec3::Zero();
      c.moment_b += Vec3::Zero();
    });
    StepWorkspace& work = world.work;
    if (work.seams_by_motion) work.seams_by_motion = cover_seams(world, world.contacts);
    return;
  }
  world.work.islands_known = false;
  persistent.list_margins(world);
  std::vector<Contact>& fresh = world.work.fresh;
  std::vector<Contact>& departed = world.work.departed;
  departed.clear();
  find_all_contacts(world, fresh, departed);
  world.work.seams_by_motion = cover_seams(world, fresh);
  if (!departed.empty()) {
    for (Contact& c : departed) follow_bodies(world, c);
    // Both are in the order of pairs; within a pair those that parted come last.
    std::vector<Contact>& merged = world.work.merged;
    merged.clear();
    std::merge(fresh.begin(), fresh.end(), departed.begin(), departed.end(),
               std::back_inserter(merged),
               [](const Contact& x, const Contact& y) { return key_of(x) < key_of(y); });
    fresh.swap(merged);
  }
  world.contacts.swap(fresh);
  world.geometry_dirty = false;
}

bool travel_grew(const World& world) {
  for (std::size_t row = 0; row < world.bodies.size(); ++row) {
    if (travel_of(world, static_cast<std::int32_t>(row), 1.0) > world.travel[row]) return true;
  }
  return false;
}

}  // namespace rb
