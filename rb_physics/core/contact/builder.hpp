// The one place that turns bodies and contacts into numbers: fills a ContactProblem for an island.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "body/body.hpp"
#include "contact/contact.hpp"
#include "contact/problem.hpp"

namespace rb {

// Bodies of an island as the problem sees them: rows[k] is body k of the problem; index_of[row] = k
// or -1. Velocities of the problem are those relative to `reference`: what rides along with a fast
// body is solved to the rounding of its own motion, not of the ride.
struct BodyIndex {
  std::span<const std::int32_t> rows;
  const std::vector<std::int32_t>* index_of = nullptr;
  Vec3 reference = Vec3::Zero();  // m/s
};

// Masses, world inverse inertias and velocities; of all bodies, or of body k of lists that are long
// enough.
void build_body(const std::vector<Body>& bodies, const BodyIndex& index, std::size_t k,
                ContactProblem& out);
void build_bodies(const std::vector<Body>& bodies, const BodyIndex& index, ContactProblem& out);

// Where a contact acts: its point and normal, and the centres of mass its arms start from.
struct ContactPlace {
  Vec3 point;     // m, world
  Vec3 normal;    // unit, world, from B to A
  Vec3 center_a;  // m, world
  Vec3 center_b;  // m, world
};
inline Vec3 middle_of(const Contact& c) { return 0.5 * (c.point.point_a + c.point.point_b); }
inline ContactPlace place_of(const std::vector<Body>& bodies, const Contact& c) {
  return {middle_of(c), c.point.normal, bodies[c.body_a].state.x, bodies[c.body_b].state.x};
}

// One contact: frame, arms, friction, and the bias that carries the velocity of an immovable B.
void set_constraint(const std::vector<Body>& bodies, const BodyIndex& index, const Contact& contact,
                    const ContactPlace& place, ContactConstraint& out);

// The same, appended.
void build_contact(const std::vector<Body>& bodies, const BodyIndex& index, const Contact& contact,
                   const ContactPlace& place, ContactProblem& out);

// What the points of a body do at this instant, world axes.
struct PointVelocities {
  explicit PointVelocities(const Body& body)
      : linear(body.linear_velocity()), angular(body.angular_velocity()), center(body.state.x) {}
  Vec3 linear;   // m/s, of the centre of mass
  Vec3 angular;  // rad/s
  Vec3 center;   // m
};

// Relative velocity of A against B at the contact point, world axes, m/s (S9: V from v + omega x r
// of both).
inline Vec3 relative_velocity(const PointVelocities& a, const PointVelocities& b,
                              const Vec3& point) {
  return a.linear + a.angular.cross(point - a.center) - b.linear -
         b.angular.cross(point - b.center);
}
inline Vec3 relative_velocity(const Body& a, const Body& b, const Vec3& point) {
  return relative_velocity(PointVelocities(a), PointVelocities(b), point);
}

// Those of the two bodies of a contact: contacts that follow each other are mostly of one pair.
class PairVelocities {
 public:
  explicit PairVelocities(const std::vector<Body>& bodies) : bodies_(bodies) {}
  Vec3 relative_at(const Contact& c, const Vec3& point) {
    look_at(c);
    return relative_velocity(*a_, *b_, point);
  }
  const PointVelocities& a() const { return *a_; }  // of the last contact
  const PointVelocities& b() const { return *b_; }
  // True where the pair is another one than before.
  bool look_at(const Contact& c) {
    if (c.body_a == row_a_ && c.body_b == row_b_) return false;
    row_a_ = c.body_a;
    row_b_ = c.body_b;
    a_.emplace(bodies_[row_a_]);
    b_.emplace(bodies_[row_b_]);
    return true;
  }

 private:
  const std::vector<Body>& bodies_;
  std::int32_t row_a_ = -1, row_b_ = -1;
  std::optional<PointVelocities> a_, b_;
};

}  // namespace rb
