#include "world/seams.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <variant>

#include "collision/extent.hpp"
#include "math/tolerances.hpp"

namespace rb {
namespace {

// The plane of a face between a body and an immovable one: it separates the two.
struct Support {
  std::int32_t collider;
  Vec3 normal;        // unit, to the body
  double height;      // m, normal . x on the plane
  double separation;  // m, of the body
  double touch;       // m
};

bool immovable(const World& world, const Contact& c) {
  return !world.bodies[c.body_b].is_dynamic();
}

// m: how far the collider reaches along the direction, or more.
double reach_along(const World& world, std::int32_t collider, const Vec3& direction) {
  const Collider& c = world.colliders[collider];
  const Pose pose = world.bodies[c.body].pose() * c.local;
  const bool surface =
      std::holds_alternative<TriangleMesh>(c.shape) || std::holds_alternative<HeightField>(c.shape);
  if (!surface) return extent(c.shape, pose, direction);
  const Aabb box = bounding_box(c.shape, Pose{});
  const Vec3 local = pose.rotate_inverse(direction);
  return direction.dot(pose.position) + 0.5 * local.dot(box.lower + box.upper) +
         0.5 * local.cwiseAbs().dot(box.upper - box.lower);
}

// The plane's own contacts, and those whose normal differs by rounding.
bool along(const Contact& c, const Vec3& normal) {
  constexpr double rounding = 1e-10;
  const double most = c.point.normal_owner == NormalOwner::CENTERS ? rounding : tolerance::parallel;
  return (c.point.normal - normal).squaredNorm() <= most * most;
}

bool covers(const World& world, const Support& s, const Contact& c) {
  if (s.collider == c.collider_b || !immovable(world, c) || along(c, s.normal)) return false;
  const double level = s.touch + c.touch;
  const double above = s.normal.dot(c.point.point_b) - s.height;
  if (above > level || above < std::fmin(0.0, s.separation) - level) return false;
  return reach_along(world, c.collider_b, s.normal) <= s.height + level;
}

// One plane for every pair of faces in the contacts of one collider A.
void find_supports(const World& world, std::span<const Contact> contacts,
                   std::vector<Support>& out) {
  out.clear();
  for (const Contact& c : contacts) {
    const bool of_face =
        c.point.normal_owner == NormalOwner::A || c.point.normal_owner == NormalOwner::B;
    if (!of_face || !immovable(world, c)) continue;
    if (!out.empty() && out.back().collider == c.collider_b &&
        (out.back().normal - c.point.normal).isZero(0.0)) {
      out.back().separation = std::fmin(out.back().separation, c.point.separation);
      continue;
    }
    out.push_back({c.collider_b, c.point.normal, c.point.normal.dot(c.point.point_b),
                   c.point.separation, c.touch});
  }
}

}  // namespace

void cover_seams(const World& world, std::span<Contact> contacts) {
  static thread_local std::vector<Support> supports;
  for (std::size_t first = 0; first < contacts.size();) {
    std::size_t last = first;
    bool several = false;  // B
    for (; last < contacts.size() && contacts[last].collider_a == contacts[first].collider_a;
         ++last) {
      contacts[last].role = ContactRole::ACTIVE;
      several |= contacts[last].collider_b != contacts[first].collider_b;
    }
    const std::span<Contact> of_a(contacts.data() + first, last - first);
    first = last;
    if (!several) continue;
    find_supports(world, of_a, supports);
    for (const Support& s : supports) {
      for (Contact& c : of_a) {
        if (c.role == ContactRole::COVERED || !covers(world, s, c)) continue;
        c.role = s.separation <= s.touch ? ContactRole::COVERED : ContactRole::SHADED;
      }
    }
  }
}

}  // namespace rb
