// The stages of a step that are too small for a header of their own.
#pragma once

#include <atomic>

#include "world/world.hpp"

namespace rb {

// Whether some contact meets the condition; asked by all threads.
template <class Condition>
bool any_contact(World& world, const Condition& condition) {
  std::atomic<bool> any = false;
  const std::vector<Contact>& contacts = world.contacts;
  world.work.crew.share_range(contacts.size(), 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && !any.load(std::memory_order_relaxed); ++i) {
      if (condition(contacts[i])) any = true;
    }
  });
  return any;
}

// change(contact) for each, shared by all threads.
template <class Change>
void share_contacts(World& world, const Change& change) {
  std::vector<Contact>& contacts = world.contacts;
  world.work.crew.share_range(contacts.size(), 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) change(contacts[i]);
  });
}

// world/wrenches.cpp
void begin_step(World& world);
Wrench external_wrench(const World& world, const Body& body);  // gravity + held wrenches, as of now
void expire_wrenches(World& world);

// world/advance_all.cpp
bool needs_detection(const World& world);
// Contacts that are gone leave the list; `known_pairs` are those that take part.
void build_islands(World& world);
void advance_islands(World& world);
Workers& workers_of(World& world);  // as many as settings.threads says
void move_kinematics(World& world);

// world/report.cpp
// Position, velocities and target are finite and so small that products of them are.
bool within_numbers(const Body& body, double h);
// More than greatest_turn in h seconds with this angular momentum (world axes).
bool turns_too_far(const Body& body, const Vec3& L, double h);
void require_finite(World& world);  // throws Diverged, with the last good state in place
void finish_step(World& world);

}  // namespace rb
