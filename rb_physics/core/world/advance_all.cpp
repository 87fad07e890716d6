// Cuts the world into islands and moves each; bodies that can meet nobody fly freely.
#include <algorithm>
#include <atomic>
#include <compare>
#include <memory>
#include <utility>

#include "body/free_motion.hpp"
#include "collision/iteration_caps.hpp"
#include "world/advance.hpp"
#include "world/detect.hpp"
#include "world/kinematic.hpp"
#include "world/sleep.hpp"
#include "world/step.hpp"

namespace rb {

bool needs_detection(const World& world) { return world.geometry_dirty || travel_grew(world); }

namespace {

bool all_active(World& world) {
  return !any_contact(world, [](const Contact& c) { return !c.active(); });
}

}  // namespace

void build_islands(World& world) {
  StepWorkspace& work = world.work;
  std::vector<Contact>& contacts = world.contacts;
  if (!work.islands_known) {
    const auto is_ghost = [](const Contact& c) { return c.role == ContactRole::GHOST; };
    if (any_contact(world, is_ghost)) std::erase_if(contacts, is_ghost);
    work.edges.resize(contacts.size());
    world.known_pairs.resize(contacts.size());
    work.crew.share_range(contacts.size(), 512, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Contact& c = contacts[i];
        work.edges[i] = {c.body_a, c.body_b};
        world.known_pairs[i] = {c.collider_a, c.collider_b};
      }
    });
    world.known_pairs.erase(std::unique(world.known_pairs.begin(), world.known_pairs.end()),
                            world.known_pairs.end());
    work.movable.clear();
    for (const Body& body : world.bodies) work.movable.push_back(body.is_dynamic());
    world.islands.build(work.movable, work.edges);
    work.islands_known = true;
  }
  work.all_active = all_active(world);
  work.index_of.assign(world.bodies.size(), -1);
  wake_islands(world);
}

namespace {

void add_stats(Stats& sum, const Stats& more) {
  sum.residual = std::max(sum.residual, more.residual);
  sum.energy_error = std::max(sum.energy_error, more.energy_error);
  sum.iterations += more.iterations;
  sum.events += more.events;
  sum.impacts += more.impacts;
  sum.capped += more.capped;
  sum.waits += more.waits;
  sum.queries_capped += more.queries_capped;
  sum.islands += more.islands;
}

// An island that has every contact of the world, all of them active: the list serves as it is.
bool is_all_there_is(const World& world, std::span<const std::int32_t> edges) {
  return !edges.empty() && edges.size() == world.contacts.size() && world.work.all_active;
}

void list_contacts(const World& world, std::span<const std::int32_t> edges,
                   IslandAdvance& advance) {
  for (const std::int32_t i : edges) {
    const Contact& c = world.contacts[i];
    if (advance.pairs.empty() || advance.pairs.back().a != c.collider_a ||
        advance.pairs.back().b != c.collider_b) {
      advance.pairs.push_back({c.collider_a, c.collider_b});
    }
    if (c.active()) {
      advance.contacts.push_back(c);
    } else if (c.role == ContactRole::COVERED) {
      advance.covered.push_back({c.collider_a, c.collider_b});
    }
  }
}

// What moving an island changes of a contact that was not found again.
void take_forces(const Contact& moved, Contact& c) {
  c.warm_force = moved.warm_force;
  c.warm_moment = moved.warm_moment;
  c.impulse = moved.impulse;
  c.moment_a = moved.moment_a;
  c.moment_b = moved.moment_b;
  c.loaded = moved.loaded;
}

void advance_island(World& world, const Island& island, IslandWorkspace& work) {
  if (sleeps(world, island)) return;
  IslandAdvance advance(world, world.islands.bodies(island), work);
  const auto edges = world.islands.edges(island);
  const bool all = is_all_there_is(world, edges);
  if (all) {
    advance.contacts.swap(world.contacts);
    for (const auto& [a, b] : world.known_pairs) advance.pairs.push_back({a, b});
  }
  const bool in_place = all || advance.take_contacts(edges);
  if (!in_place) list_contacts(world, edges, advance);
  if (!edges.empty()) advance.stats.islands = 1;
  {
    const IterationCapCounter caps(advance.stats.queries_capped);
    advance.run(world.settings.dt);
  }
  if (advance.found_again) {
    for (const std::int32_t i : edges) world.work.replaced[i] = 1;
    world.work.persistent.replace(world.islands.bodies(island));
    work.any_replaced = true;
    work.replaced.insert(work.replaced.end(), advance.contacts.begin(), advance.contacts.end());
    work.replaced.insert(work.replaced.end(), advance.departed.begin(), advance.departed.end());
  } else if (in_place) {
    world.contacts.swap(advance.contacts);
  } else {
    std::size_t k = 0;
    for (const std::int32_t i : edges) {
      if (world.contacts[i].active()) take_forces(advance.contacts[k++], world.contacts[i]);
    }
  }
  add_stats(work.stats, advance.stats);
}

// Islands that meet a kinematic body move it about while they look for contact times.
bool meets_kinematic(const World& world, const Island& island) {
  const auto edges = world.islands.edges(island);
  return std::any_of(edges.begin(), edges.end(), [&](std::int32_t i) {
    return world.bodies[world.contacts[i].body_b].type == BodyType::KINEMATIC;
  });
}

void advance_in_parallel(World& world) {
  StepWorkspace& work = world.work;
  const std::vector<Island>& islands = world.islands.all();
  work.alone.clear();
  for (std::size_t k = 0; k < islands.size(); ++k) {
    const bool shares = is_large_island(world.islands.edges(islands[k]).size());
    if (shares || meets_kinematic(world, islands[k]))
      work.alone.push_back(static_cast<std::int32_t>(k));
  }
  const std::size_t block = std::max<std::size_t>(1, islands.size() / (16 * work.threads.size()));
  const auto blocks = static_cast<std::int32_t>((islands.size() + block - 1) / block);
  work.crew.share(blocks, [&](int worker, std::int32_t b) {
    const std::size_t first = static_cast<std::size_t>(b) * block;
    const std::size_t end = std::min(islands.size(), first + block);
    for (std::size_t k = first; k < end; ++k) {
      const auto number = static_cast<std::int32_t>(k);
      if (std::binary_search(work.alone.begin(), work.alone.end(), number)) continue;
      advance_island(world, islands[k], work.threads[worker]);
    }
  });
  for (const std::int32_t k : work.alone) advance_island(world, islands[k], work.threads[0]);
}

// Puts the contacts that were found on the way in place of those they replace, in the order of
// pairs; within a pair the order stays.
void merge_replaced(World& world) {
  StepWorkspace& work = world.work;
  struct Place {
    std::int32_t a, b, thread, index;
    auto operator<=>(const Place&) const = default;
  };
  static thread_local std::vector<Place> places;
  places.clear();
  for (std::size_t t = 0; t < work.threads.size(); ++t) {
    const std::vector<Contact>& replaced = work.threads[t].replaced;
    for (std::size_t k = 0; k < replaced.size(); ++k) {
      places.push_back({replaced[k].collider_a, replaced[k].collider_b,
                        static_cast<std::int32_t>(t), static_cast<std::int32_t>(k)});
    }
  }
  std::sort(places.begin(), places.end());  // a pair is of one island, so of one thread
  work.merged.clear();
  auto next = places.begin();
  for (std::size_t i = 0; i < world.contacts.size(); ++i) {
    if (work.replaced[i]) continue;
    const Contact& c = world.contacts[i];
    for (; next != places.end() &&
           std::pair(next->a, next->b) < std::pair(c.collider_a, c.collider_b);
         ++next) {
      work.merged.push_back(work.threads[next->thread].replaced[next->index]);
    }
    work.merged.push_back(c);
  }
  for (; next != places.end(); ++next)
    work.merged.push_back(work.threads[next->thread].replaced[next->index]);
  world.contacts.swap(work.merged);
}

}  // namespace

Workers& workers_of(World& world) {
  const int wanted = world.settings.threads;
  if (!world.workers || world.workers->count() != wanted)
    world.workers = std::make_unique<Workers>(wanted);
  if (world.work.threads.size() < static_cast<std::size_t>(wanted))
    world.work.threads.resize(wanted);
  return *world.workers;
}

void advance_islands(World& world) {
  StepWorkspace& work = world.work;
  for (IslandWorkspace& thread : work.threads) {
    thread.replaced.clear();
    thread.any_replaced = false;
    thread.stats = Stats{};
  }
  work.replaced.assign(world.contacts.size(), 0);
  const std::vector<Island>& islands = world.islands.all();
  if (work.crew.helped() && islands.size() > 1) {
    advance_in_parallel(world);
  } else {
    for (const Island& island : islands) advance_island(world, island, work.threads[0]);
  }
  bool any_replaced = false;
  for (const IslandWorkspace& thread : work.threads) {
    add_stats(world.stats, thread.stats);
    any_replaced |= thread.any_replaced;
  }
  if (any_replaced) merge_replaced(world);
}

void move_kinematics(World& world) {
  for (Body& body : world.bodies) {
    if (body.type == BodyType::KINEMATIC) move_kinematic(body, world.settings.dt);
  }
}

}  // namespace rb
