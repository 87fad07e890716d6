#include "world/persistent_manifolds.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "world/detect.hpp"
#include "world/world.hpp"

namespace rb {
namespace {

constexpr std::size_t kFewBodies = 512;  // not worth another thread

std::pair<std::int32_t, std::int32_t> key(const ColliderPair& p) { return {p.a, p.b}; }

bool same_pair(const ColliderPair& x, const ColliderPair& y) { return x.a == y.a && x.b == y.b; }

}  // namespace

void PersistentManifolds::begin(World& world) {
  const std::size_t n = world.bodies.size();
  const Settings& settings = world.settings;
  const bool known = known_ && !world.geometry_dirty && placements_.size() == n &&
                     friction_ == settings.friction_combine &&
                     restitution_ == settings.restitution_combine;
  known_ = false;  // until the detection is through
  friction_ = settings.friction_combine;
  restitution_ = settings.restitution_combine;
  placements_.resize(n);
  stayed_.resize(n);
  replaced_.resize(n);
  world.work.crew.share_range(n, kFewBodies, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      const RigidState& s = world.bodies[row].state;
      const Placement now{s.x[0], s.x[1], s.x[2], s.q.x(), s.q.y(), s.q.z(), s.q.w()};
      stayed_[row] = known && !replaced_[row] &&
                     std::memcmp(now.data(), placements_[row].data(), sizeof(Placement)) == 0;
      placements_[row] = now;
      replaced_[row] = 0;
    }
  });
  old_pairs_.swap(world.pairs);
  old_margins_.swap(margins_);
  old_margins_.resize(old_pairs_.size(), std::numeric_limits<double>::quiet_NaN());
}

void PersistentManifolds::list_margins(const World& world) {
  margins_.resize(world.pairs.size());
  known_ = true;
}

void PersistentManifolds::looked_at(std::size_t k, double margin, std::span<const Contact> contacts,
                                    bool capped) {
  bool keep = !capped;
  for (std::size_t i = 1; i < contacts.size() && keep; ++i) {
    const auto feature = contacts[i].point.feature;
    keep = std::none_of(contacts.begin(), contacts.begin() + static_cast<std::ptrdiff_t>(i),
                        [&](const Contact& c) { return c.point.feature == feature; });
  }
  margins_[k] = keep ? margin : std::numeric_limits<double>::quiet_NaN();
}

bool PersistentManifolds::keeps(const World& world, std::size_t k, double margin) const {
  const ColliderPair& pair = world.pairs[k];
  if (!stayed_[world.colliders[pair.a].body] || !stayed_[world.colliders[pair.b].body])
    return false;
  std::size_t old = k;
  if (!(old < old_pairs_.size() && same_pair(old_pairs_[old], pair))) {
    const auto before = [](const ColliderPair& x, const ColliderPair& y) {
      return key(x) < key(y);
    };
    const auto at = std::lower_bound(old_pairs_.begin(), old_pairs_.end(), pair, before);
    if (at == old_pairs_.end() || !same_pair(*at, pair)) return false;
    old = static_cast<std::size_t>(at - old_pairs_.begin());
  }
  return old_margins_[old] == margin;
}

bool PersistentManifolds::keeps_all(const World& world) {
  // Where nobody stayed nothing may be known, not even how many there are.
  const bool any_stayed = std::find(stayed_.begin(), stayed_.end(), 1) != stayed_.end();
  if (!any_stayed || world.pairs.size() != old_pairs_.size()) return false;
  for (std::size_t k = 0; k < world.pairs.size(); ++k) {
    if (!same_pair(old_pairs_[k], world.pairs[k])) return false;
    if (!keeps(world, k, pair_margin(world, world.pairs[k]))) return false;
  }
  if (!as_found(world.contacts)) return false;
  margins_.swap(old_margins_);
  known_ = true;
  return true;
}

bool PersistentManifolds::as_found(std::span<const Contact> contacts) {
  return std::none_of(contacts.begin(), contacts.end(),
                      [](const Contact& c) { return c.lifted || c.role == ContactRole::GHOST; });
}

}  // namespace rb
