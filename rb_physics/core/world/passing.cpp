// Nothing goes through a surface: a last look at where a body really ends up.
#include <algorithm>
#include <cmath>

#include "collision/surface_contacts.hpp"
#include "collision/surface_features.hpp"
#include "world/advance.hpp"

namespace rb {

// m: what of the pair's way may overlap before the wrong side is the nearer one. A surface lets go
// of a particle behind it at once.
double IslandAdvance::width_between(const ColliderPair& pair) const {
  const Collider& a = world_.colliders[pair.a];
  const Collider& b = world_.colliders[pair.b];
  if (std::holds_alternative<Particle>(a.shape) && is_surface(b.shape)) return 0.0;
  return a.width + b.width;
}

// The share of the way within tau after which the middle of a shape is behind the surface it was in
// front of; nothing where it stays in front.
std::optional<double> IslandAdvance::passes_at(const ColliderPair& pair, double tau) const {
  const Collider& a = world_.colliders[pair.a];
  const Collider& b = world_.colliders[pair.b];
  const Body& body = world_.bodies[a.body];
  if (!is_surface(b.shape) || !body.is_dynamic()) return std::nullopt;
  const std::int32_t k = world_.work.index_of[a.body];
  const double shift = shift_.empty() ? 0.0 : shift_[k].head<3>().norm();
  if (closing_bound(pair, tau) + shift <= 0.25 * width_between(pair)) return std::nullopt;
  Pose end = pose_at(a.body, tau);
  if (!shift_.empty()) end.position += shift_[k].head<3>();
  const auto on_surface = [&](const Pose& pose, const Pose& ground) {
    return center_of(a.shape, (ground * b.local).inverse() * (pose * a.local));
  };
  return surface_crossing(a.shape, b.shape, on_surface(body.pose(), pose_at(b.body, 0.0)),
                          on_surface(end, pose_at(b.body, tau)));
}

bool IslandAdvance::stop_short(double& tau) {
  if (active_.empty()) return false;  // free flight: the contact time is exact
  constexpr double least_share = 1e-3;
  const double whole = tau;
  for (;;) {
    double share = 1.0;
    for (const ColliderPair& pair : pairs) {
      const std::optional<double> at = passes_at(pair, tau);
      if (!at || !(*at < share)) continue;
      share = *at;
      met_ = pair;
    }
    if (share == 1.0) return tau < whole;
    tau *= std::clamp(0.9 * share, 0.01, 0.9);         // in front, where the face ahead is seen
    const bool too_short = tau < least_share * whole;  // it was there from the beginning
    if (too_short) tau = whole;
    carry(tau, false);
    settle(tau, false);
    if (too_short) return false;
  }
}

}  // namespace rb
