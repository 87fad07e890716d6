// Broad phase: which bodies may touch. Two dynamic AABB trees (moving and passive bodies) hold fat
// boxes; only a body that leaves its fat box is looked at again.
//
// Bodies are numbered 0 .. size() - 1 in the order of insertion, as the rows of a world; removing
// one moves later numbers down by one.
//
// Pairs depend on the present predicted boxes alone: the fat boxes only collect candidates, which
// every update tests again. A world restored from a snapshot so gets the same pairs, bit for bit,
// whatever its history.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "body/collision_filter.hpp"
#include "collision/aabb_tree.hpp"
#include "math/types.hpp"
#include "shape/bvh.hpp"

namespace rb {

class BroadPhase {
 public:
  // `fat_margin`: room added to the fat box of a body that moves, relative to its largest extent.
  // Larger: fewer tree updates, more candidates. No effect on the pairs.
  explicit BroadPhase(double fat_margin = 0.1);

  // Adds a body and returns its number. `tight` in m, lower <= upper, may be infinite (such bodies
  // are tested one by one). `passive`: static or kinematic; two passive bodies never pair. Throws
  // std::invalid_argument for NaN or lower > upper.
  int insert(const Aabb& tight, const CollisionFilter& filter, bool passive);

  // The same for the half-space normal . x <= offset (unit normal, m), which no box bounds: it
  // pairs with the bodies whose box reaches below the plane.
  int insert_half_space(const Vec3& normal, double offset, const CollisionFilter& filter,
                        bool passive = true);

  void remove(int body);  // later bodies move down by one
  void clear();

  // New tight box; `displacement` (m) is how far it may travel until the next update: the predicted
  // box holds the box at both ends.
  void move(int body, const Aabb& tight, const Vec3& displacement = Vec3::Zero());
  void move_half_space(int body, const Vec3& normal, double offset);

  void set_filter(int body, const CollisionFilter& filter);
  void set_passive(int body, bool passive);

  // Pairs (a, b), a < b, sorted, whose predicted boxes overlap, at most one body passive, filters
  // agreeing. Valid until the next call.
  const std::vector<std::pair<int, int>>& update_pairs();
  const std::vector<std::pair<int, int>>& pairs() const { return pairs_; }

  // Numbers of the bodies whose predicted box (or half-space) meets `box`, ascending, into `out`.
  void query(const Aabb& box, std::vector<int>& out) const;

  // Calls visit(body) -> double for bodies whose predicted box the ray origin + t direction,
  // t in [0, t_max], enters; the returned value is the new t_max (return t_max to go on unchanged).
  // The order is that of the tree: a caller that looks for the nearest hit breaks ties by number.
  template <class Visit>
  void ray(const Vec3& origin, const Vec3& direction, double t_max, Visit&& visit) const;

  int size() const { return static_cast<int>(proxies_.size()); }
  const Aabb& predicted_box(int body) const { return proxies_.at(body).predicted; }
  int candidates() const { return static_cast<int>(candidates_.size()); }
  const AabbTree& moving_tree() const { return trees_[0]; }
  const AabbTree& passive_tree() const { return trees_[1]; }

 private:
  enum class Kind : std::uint8_t { BOUNDED, UNBOUNDED, HALF_SPACE };
  struct Proxy {
    Aabb predicted{Vec3::Zero(), Vec3::Zero()};
    Vec3 normal = Vec3::Zero();  // half-spaces only
    double offset = 0.0;
    CollisionFilter filter;
    std::int32_t leaf = -1;  // in trees_[passive]
    Kind kind = Kind::BOUNDED;
    bool passive = false;
    bool queued = false;  // left its fat box (or is new): candidates are stale
    bool fat = false;     // has moved before: gets a margin
  };

  int add(Proxy proxy);
  void enqueue(int body);
  void place(int body, const Aabb& box, const Vec3& displacement);
  void refresh_candidates();
  bool may_pair(const Proxy& a, const Proxy& b) const {
    return !(a.passive && b.passive) && a.filter.accepts(b.filter);
  }
  bool meets(const Proxy& p, const Aabb& box) const;  // predicted box or half-space against a box
  bool fat_boxes_meet(const Proxy& a, const Proxy& b) const;

  double fat_margin_;
  AabbTree trees_[2];  // moving, passive
  std::vector<Proxy> proxies_;
  std::vector<int> unbounded_;             // ascending
  std::vector<int> queue_;                 // bodies with queued == true
  std::vector<std::uint64_t> candidates_;  // a << 32 | b, a < b, sorted
  std::vector<std::uint64_t> fresh_, merged_;
  std::vector<std::pair<int, int>> pairs_;
  bool dirty_ = true;  // some predicted box changed since update_pairs
};

template <class Visit>
void BroadPhase::ray(const Vec3& origin, const Vec3& direction, double t_max, Visit&& visit) const {
  for (const int body : unbounded_) t_max = visit(body);
  for (const AabbTree& tree : trees_) {
    tree.walk([&](const Aabb& box) { return ray_meets(box, origin, direction, t_max); },
              [&](std::int32_t body) {
                if (ray_meets(proxies_[body].predicted, origin, direction, t_max)) {
                  t_max = visit(body);
                }
              });
  }
}

}  // namespace rb
