// The one place that turns bodies and contacts into numbers: fills a ContactProblem for an island.
#pragma once

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
ContactPlace place_of(const std::vector<Body>& bodies, const Contact& contact);

// One contact: frame, arms, friction, and the bias that carries the velocity of an immovable B.
ContactConstraint make_constraint(const std::vector<Body>& bodies, const BodyIndex& index,
                                  const Contact& contact, const ContactPlace& place);

// The same, appended.
void build_contact(const std::vector<Body>& bodies, const BodyIndex& index, const Contact& contact,
                   const ContactPlace& place, ContactProblem& out);

// Relative velocity of A against B at the contact point, world axes, m/s (S9: V from v + omega x r
// of both).
Vec3 relative_velocity(const Body& a, const Body& b, const Vec3& point);

}  // namespace rb
