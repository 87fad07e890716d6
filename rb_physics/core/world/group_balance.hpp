// What a step owes to conservation beyond its contact solves. Bodies that push one another form a
// group. Over an interval in which contacts turn, or by a displacement that no momentum sees, a
// group may gain energy or change its x x p, both of second order in the interval: it gives them
// back here.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "contact/contact.hpp"
#include "math/types.hpp"

namespace rb {
struct World;

// What one body of an island has gained.
struct BodyGain {
  double energy = 0.0;          // J, kinetic, less the work done on it from outside, as seen from
                                // the frame that moves with `reference`
  Vec3 impulse = Vec3::Zero();  // N s, of contacts: what the energy is in other frames
  Vec3 angular = Vec3::Zero();  // N m s, of x x p, by displacements
};

// Scratch memory.
struct GroupWorkspace {
  std::vector<std::int32_t> first, next;  // links of each body
  std::vector<std::int32_t> members, order, parent, link;
  std::vector<std::uint8_t> listed;
  std::vector<Vec3> impulse, moment;
};

// Takes back, group by group, what the groups that `links` (indices of contacts) make of the bodies
// `rows` gained (gains[k] is that of rows[k]; World::work.index_of[row] = k):
//  - angular momentum of groups that meet nothing immovable: the group turns, as one rigid body,
//    less fast, so that the relative velocities of all its contacts stay;
//  - energy, where there is more than before: what moves within the group, or against the immovable
//    bodies it meets, slows down in one proportion, so that every contact keeps its class (S9) and
//    its slip the direction. Groups that meet something that turns, or moves in several ways, may
//    gain the work of it and keep theirs.
// Both are booked as impulses and moments of the contacts.
void take_back_gains(World& world, std::span<const std::int32_t> rows,
                     std::vector<Contact>& contacts, std::span<const std::int32_t> links,
                     std::span<const BodyGain> gains, const Vec3& reference, GroupWorkspace& work);

}  // namespace rb
