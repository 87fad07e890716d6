// Cuts the world into islands and moves each; bodies that can meet nobody fly freely.
#include <algorithm>

#include "body/free_motion.hpp"
#include "world/advance.hpp"
#include "world/detect.hpp"
#include "world/kinematic.hpp"
#include "world/step.hpp"

namespace rb {

bool needs_detection(const World& world) { return world.geometry_dirty || travel_grew(world); }

void build_islands(World& world) {
  std::erase_if(world.contacts, [](const Contact& c) { return c.ghost; });
  StepWorkspace& work = world.work;
  work.movable.clear();
  for (const Body& body : world.bodies) work.movable.push_back(body.is_dynamic());
  work.edges.clear();
  for (const Contact& c : world.contacts) work.edges.emplace_back(c.body_a, c.body_b);
  world.islands.build(work.movable, work.edges);
  work.index_of.assign(world.bodies.size(), -1);
}

void advance_islands(World& world) {
  std::vector<Contact> replaced;       // of islands whose contacts were found again on the way
  std::vector<std::uint8_t> outdated;  // per contact, when there are such islands
  for (const Island& island : world.islands.all()) {
    IslandAdvance advance(world, world.islands.bodies(island));
    for (const std::int32_t i : world.islands.edges(island)) {
      const Contact& c = world.contacts[i];
      if (advance.pairs.empty() || advance.pairs.back().a != c.collider_a ||
          advance.pairs.back().b != c.collider_b) {
        advance.pairs.push_back({c.collider_a, c.collider_b});
      }
      advance.contacts.push_back(c);
    }
    advance.run(world.settings.dt);
    if (advance.found_again) {
      outdated.resize(world.contacts.size(), 0);
      for (const std::int32_t i : world.islands.edges(island)) outdated[i] = 1;
      replaced.insert(replaced.end(), advance.contacts.begin(), advance.contacts.end());
      replaced.insert(replaced.end(), advance.departed.begin(), advance.departed.end());
    } else {
      std::size_t k = 0;
      for (const std::int32_t i : world.islands.edges(island)) {
        world.contacts[i] = advance.contacts[k++];
      }
    }
    world.stats.residual = std::max(world.stats.residual, advance.stats.residual);
    world.stats.energy_error = std::max(world.stats.energy_error, advance.stats.energy_error);
    world.stats.iterations += advance.stats.iterations;
    world.stats.events += advance.stats.events;
    world.stats.impacts += advance.stats.impacts;
    world.stats.capped += advance.stats.capped;
    if (!advance.pairs.empty()) ++world.stats.islands;
  }
  if (outdated.empty()) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < world.contacts.size(); ++i) {
    if (outdated[i]) continue;
    if (kept != i) world.contacts[kept] = world.contacts[i];
    ++kept;
  }
  world.contacts.resize(kept);
  world.contacts.insert(world.contacts.end(), replaced.begin(), replaced.end());
  // Back to the order of pairs; within a pair the order stays.
  std::stable_sort(
      world.contacts.begin(), world.contacts.end(), [](const Contact& x, const Contact& y) {
        return std::pair(x.collider_a, x.collider_b) < std::pair(y.collider_a, y.collider_b);
      });
}

void move_kinematics(World& world) {
  for (Body& body : world.bodies) {
    if (body.type == BodyType::KINEMATIC) move_kinematic(body, world.settings.dt);
  }
}

}  // namespace rb
