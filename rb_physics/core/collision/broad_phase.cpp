#include "collision/broad_phase.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace rb {
namespace {

// A fat box looks this many updates ahead along the motion.
constexpr double steps_ahead = 4.0;

std::uint64_t key(int a, int b) {
  const std::uint64_t lo = static_cast<std::uint64_t>(std::min(a, b));
  const std::uint64_t hi = static_cast<std::uint64_t>(std::max(a, b));
  return lo << 32 | hi;
}
int first(std::uint64_t k) { return static_cast<int>(k >> 32); }
int second(std::uint64_t k) { return static_cast<int>(k & 0xffffffffu); }

bool holds(const Aabb& outer, const Aabb& inner) {
  return (outer.lower.array() <= inner.lower.array()).all() &&
         (inner.upper.array() <= outer.upper.array()).all();
}

// Does the box reach into normal . x <= offset?
bool reaches_below(const Aabb& box, const Vec3& normal, double offset) {
  double lowest = 0.0;
  for (int k = 0; k < 3; ++k) {
    if (normal[k] == 0.0) continue;  // 0 * infinity is NaN
    lowest += normal[k] > 0.0 ? normal[k] * box.lower[k] : normal[k] * box.upper[k];
  }
  // A box that is infinite both ways along the normal gives inf - inf: it reaches everywhere.
  return !(lowest > offset);
}

Aabb swept(const Aabb& box, const Vec3& d) {
  return {box.lower + d.cwiseMin(0.0), box.upper + d.cwiseMax(0.0)};
}

void check_box(const Aabb& box, const Vec3& displacement) {
  if (!(box.lower.array() <= box.upper.array()).all()) {
    throw std::invalid_argument("broad phase: box must have lower <= upper in every axis, no NaN");
  }
  if (!displacement.allFinite()) {
    throw std::invalid_argument("broad phase: displacement must be finite");
  }
}

void check_plane(const Vec3& normal, double offset) {
  if (!(std::abs(normal.squaredNorm() - 1.0) < 1e-9) || !std::isfinite(offset)) {
    throw std::invalid_argument("broad phase: half-space needs a unit normal and a finite offset");
  }
}

}  // namespace

BroadPhase::BroadPhase(double fat_margin) : fat_margin_(fat_margin) {
  if (!(fat_margin >= 0.0) || !std::isfinite(fat_margin)) {
    throw std::invalid_argument("broad phase: fat_margin must be finite and >= 0");
  }
}

int BroadPhase::add(Proxy proxy) {
  const int body = size();
  proxies_.push_back(proxy);
  if (proxy.kind != Kind::BOUNDED) unbounded_.push_back(body);
  enqueue(body);
  return body;
}

void BroadPhase::enqueue(int body) {
  dirty_ = true;
  if (proxies_[body].queued) return;
  proxies_[body].queued = true;
  queue_.push_back(body);
}

int BroadPhase::insert(const Aabb& tight, const CollisionFilter& filter, bool passive) {
  check_box(tight, Vec3::Zero());
  Proxy p;
  p.predicted = tight;
  p.filter = filter;
  p.passive = passive;
  p.kind = tight.lower.allFinite() && tight.upper.allFinite() ? Kind::BOUNDED : Kind::UNBOUNDED;
  const int body = add(p);
  if (p.kind == Kind::BOUNDED) place(body, tight, Vec3::Zero());
  return body;
}

int BroadPhase::insert_half_space(const Vec3& normal, double offset, const CollisionFilter& filter,
                                  bool passive) {
  check_plane(normal, offset);
  constexpr double inf = std::numeric_limits<double>::infinity();
  Proxy p;
  p.predicted = {Vec3::Constant(-inf), Vec3::Constant(inf)};
  p.normal = normal;
  p.offset = offset;
  p.filter = filter;
  p.passive = passive;
  p.kind = Kind::HALF_SPACE;
  return add(p);
}

// (Re)inserts the body's leaf with a fat box around its predicted box.
void BroadPhase::place(int body, const Aabb& box, const Vec3& displacement) {
  Proxy& p = proxies_[body];
  AabbTree& tree = trees_[p.passive];
  if (p.leaf >= 0) tree.remove(p.leaf);
  Aabb fat = box;
  if (p.fat || !p.passive) {
    const Vec3 margin = Vec3::Constant(fat_margin_ * (box.upper - box.lower).maxCoeff());
    fat = swept(fat, (steps_ahead - 1.0) * displacement);
    fat.lower -= margin;
    fat.upper += margin;
  }
  p.leaf = tree.insert(fat, body);
}

void BroadPhase::move(int body, const Aabb& tight, const Vec3& displacement) {
  Proxy& p = proxies_.at(body);
  check_box(tight, displacement);
  if (p.kind == Kind::HALF_SPACE) {
    throw std::invalid_argument("broad phase: use move_half_space for a half-space");
  }
  const Aabb predicted = swept(tight, displacement);
  if (predicted.lower == p.predicted.lower && predicted.upper == p.predicted.upper) return;
  const bool bounded = predicted.lower.allFinite() && predicted.upper.allFinite();
  if (bounded != (p.kind == Kind::BOUNDED)) {
    throw std::invalid_argument("broad phase: a box can't turn from finite to infinite or back");
  }
  p.predicted = predicted;
  dirty_ = true;
  p.fat = true;
  if (!bounded) {
    enqueue(body);
    return;
  }
  const Aabb& fat = trees_[p.passive].box(p.leaf);
  // A fat box left over from fast motion is given back once it is far too large.
  const Vec3 room = (fat.upper - fat.lower) - (predicted.upper - predicted.lower);
  const double extent = (predicted.upper - predicted.lower).maxCoeff();
  const double travel = displacement.lpNorm<Eigen::Infinity>();
  const bool oversized =
      room.maxCoeff() > 4.0 * fat_margin_ * extent + 2.0 * steps_ahead * travel &&
      room.maxCoeff() > extent;
  if (holds(fat, predicted) && !oversized) return;
  place(body, predicted, displacement);
  enqueue(body);
}

void BroadPhase::move_half_space(int body, const Vec3& normal, double offset) {
  Proxy& p = proxies_.at(body);
  check_plane(normal, offset);
  if (p.kind != Kind::HALF_SPACE) {
    throw std::invalid_argument("broad phase: move_half_space on a body that is no half-space");
  }
  if (p.normal == normal && p.offset == offset) return;
  p.normal = normal;
  p.offset = offset;
  enqueue(body);
}

void BroadPhase::set_filter(int body, const CollisionFilter& filter) {
  proxies_.at(body).filter = filter;
  enqueue(body);
}

void BroadPhase::set_passive(int body, bool passive) {
  Proxy& p = proxies_.at(body);
  if (p.passive == passive) return;
  if (p.leaf >= 0) trees_[p.passive].remove(p.leaf);
  p.leaf = -1;
  p.passive = passive;
  if (p.kind == Kind::BOUNDED) place(body, p.predicted, Vec3::Zero());
  enqueue(body);
}

void BroadPhase::remove(int body) {
  const Proxy& p = proxies_.at(body);
  if (p.leaf >= 0) trees_[p.passive].remove(p.leaf);
  proxies_.erase(proxies_.begin() + body);
  for (int i = body; i < size(); ++i) {
    if (proxies_[i].leaf >= 0) trees_[proxies_[i].passive].set_user(proxies_[i].leaf, i);
  }
  const auto renumber = [body](std::vector<int>& list) {
    std::erase(list, body);
    for (int& i : list) i -= i > body;
  };
  renumber(unbounded_);
  renumber(queue_);
  std::erase_if(candidates_,
                [body](std::uint64_t k) { return first(k) == body || second(k) == body; });
  for (std::uint64_t& k : candidates_) {
    k = key(first(k) - (first(k) > body), second(k) - (second(k) > body));
  }
  dirty_ = true;
}

void BroadPhase::clear() { *this = BroadPhase(fat_margin_); }

bool BroadPhase::meets(const Proxy& p, const Aabb& box) const {
  return p.kind == Kind::HALF_SPACE ? reaches_below(box, p.normal, p.offset)
                                    : p.predicted.overlaps(box);
}

// Candidates among the unbounded are collected with the bounded partner's fat box, so that they
// stay complete until it leaves that box.
bool BroadPhase::fat_boxes_meet(const Proxy& a, const Proxy& b) const {
  if (a.leaf >= 0) return meets(b, trees_[a.passive].box(a.leaf));
  if (b.leaf >= 0) return meets(a, trees_[b.passive].box(b.leaf));
  return true;
}

// Drops the candidates of every queued body and collects them anew.
void BroadPhase::refresh_candidates() {
  if (queue_.empty()) return;
  std::sort(queue_.begin(), queue_.end());
  fresh_.clear();
  for (const int body : queue_) {
    const Proxy& p = proxies_[body];
    const auto consider = [&](int other) {
      const Proxy& o = proxies_[other];
      if (other == body || (o.queued && other < body)) return;  // collected once, by the smaller
      if (may_pair(p, o)) fresh_.push_back(key(body, other));
    };
    if (p.kind == Kind::BOUNDED) {
      const Aabb fat = trees_[p.passive].box(p.leaf);
      const auto accept = [&](const Aabb& box) { return box.overlaps(fat); };
      trees_[0].walk(accept, consider);
      if (!p.passive) trees_[1].walk(accept, consider);
      for (const int other : unbounded_) {
        if (fat_boxes_meet(p, proxies_[other])) consider(other);
      }
    } else {
      for (int other = 0; other < size(); ++other) {
        if (fat_boxes_meet(p, proxies_[other])) consider(other);
      }
    }
  }
  std::sort(fresh_.begin(), fresh_.end());
  std::erase_if(candidates_, [this](std::uint64_t k) {
    return proxies_[first(k)].queued || proxies_[second(k)].queued;
  });
  merged_.resize(candidates_.size() + fresh_.size());
  std::merge(candidates_.begin(), candidates_.end(), fresh_.begin(), fresh_.end(), merged_.begin());
  candidates_.swap(merged_);
  for (const int body : queue_) proxies_[body].queued = false;
  queue_.clear();
}

const std::vector<std::pair<int, int>>& BroadPhase::update_pairs() {
  if (!dirty_) return pairs_;
  refresh_candidates();
  pairs_.clear();
  for (const std::uint64_t k : candidates_) {
    const Proxy& a = proxies_[first(k)];
    const Proxy& b = proxies_[second(k)];
    const bool overlap = a.kind == Kind::HALF_SPACE
                             ? b.kind == Kind::HALF_SPACE || meets(a, b.predicted)
                             : meets(b, a.predicted);
    if (overlap) pairs_.emplace_back(first(k), second(k));
  }
  dirty_ = false;
  return pairs_;
}

void BroadPhase::query(const Aabb& box, std::vector<int>& out) const {
  check_box(box, Vec3::Zero());
  out.clear();
  for (const AabbTree& tree : trees_) {
    tree.walk([&](const Aabb& b) { return b.overlaps(box); },
              [&](std::int32_t body) {
                if (proxies_[body].predicted.overlaps(box)) out.push_back(body);
              });
  }
  for (const int body : unbounded_) {
    if (meets(proxies_[body], box)) out.push_back(body);
  }
  std::sort(out.begin(), out.end());
}

}  // namespace rb
