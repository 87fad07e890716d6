// The world: bodies, their colliders, contacts, time. Data is plain; each stage of the step is a
// function in a file of its own, and world/step.cpp is the table of contents.
#pragma once

#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "body/body.hpp"
#include "collision/broad_phase.hpp"
#include "contact/contact.hpp"
#include "island/island.hpp"
#include "math/crew.hpp"
#include "math/workers.hpp"
#include "shape/shape.hpp"
#include "world/island_workspace.hpp"
#include "world/persistent_manifolds.hpp"
#include "world/settings.hpp"
#include "world/stats.hpp"

namespace rb {

// One leaf shape of a body, placed in body coordinates.
struct Collider {
  Shape shape;
  Pose local;
  std::int32_t body = -1;  // row
  std::int32_t part = 0;   // index within the body
  double size = 1.0;       // m, characteristic length
  double width = 0.0;      // m, least_width
  double reach = 0.0;      // m, farthest point from the body's centre of mass
};

// A kinematic body as it was at the start of the step.
struct KinematicStart {
  RigidState state;
  Vec3 velocity;
  Vec3 spin;
  std::optional<Pose> target;
};

// What the contacts of two bodies did since it was last asked for, world axes.
struct PairImpulse {
  std::int32_t body_a = -1;      // row, as in the contacts
  std::int32_t body_b = -1;      // row
  Vec3 impulse = Vec3::Zero();   // N s, on A (on B: the opposite)
  Vec3 moment_a = Vec3::Zero();  // N m s, on A about its moving centre of mass
  Vec3 moment_b = Vec3::Zero();  // N m s, on B about its moving centre of mass
};

// What the broad phase was last told of a collider.
struct ProxyBox {
  Aabb box;                 // with room around it
  Vec3 way = Vec3::Zero();  // m, in the step
  double room = 0.0;        // m; NaN where there was a way
  bool same = false;        // as in the last detection
};

// What one block of pairs has: their contacts, and those of old that are gone.
struct FoundContacts {
  std::vector<Contact> contacts, departed;
  std::size_t first = 0;  // place of the contacts in the world's list
};

// Scratch memory of the step: no allocation after warm-up.
struct StepWorkspace {
  std::vector<IslandWorkspace> threads{1};  // one per thread
  std::vector<std::uint8_t> movable;
  std::vector<std::pair<std::int32_t, std::int32_t>> edges;
  std::vector<std::int32_t> index_of;  // row -> body of its island's problem
  std::vector<std::uint8_t> replaced;  // per contact: its island has found its contacts again
  std::vector<std::int32_t> alone;     // islands to be moved by one thread, in order
  std::vector<std::int32_t> near_rows, near_contacts;  // see find_neighbourhood
  std::vector<Contact> merged, departed, fresh;
  std::vector<FoundContacts> found;     // per block of pairs, when threads share them
  std::vector<ProxyBox> boxes;          // of colliders
  std::vector<std::int32_t> next_pair;  // of each collider A: where its next pair goes
  PersistentManifolds persistent;
  bool seams_by_motion = true;  // what seams cover depends on velocities
  bool islands_known = false;   // they are those of the contacts
  Crew crew;                    // the threads of the step
  bool all_active = false;      // every contact takes part
};

struct World {
  Settings settings;
  std::vector<Body> bodies;         // rows in the order of adding
  std::vector<Collider> colliders;  // grouped by body, in row order
  std::vector<Contact> contacts;    // by pair, then as the manifold lists them
  std::vector<ColliderPair> pairs;  // candidates of the current step, ordered
  std::vector<Wrench> applied;      // gravity and applied wrenches of the current step, per row
  std::uint64_t step_count = 0;
  std::vector<double> reach;   // m, farthest surface point from the centre of mass, per row
  std::vector<double> travel;  // m a surface may move in the step beyond dt * v, per row
  bool geometry_dirty = true;  // something moved from outside: look for contacts again
  Stats stats;
  WorstOfSteps worst;

  std::vector<RigidState>
      last_good;  // states at the start of the step: what a diverged step falls back to
  std::vector<double> extra_travel;  // m, per row; zero when a step begins
  std::vector<std::pair<std::int32_t, std::int32_t>> known_pairs;  // collider pairs of the step
  std::vector<KinematicStart> kinematic_start;
  bool keep_hashes = false;  // log the state hash of every step into `hashes`
  std::vector<std::uint64_t> hashes;
  bool keep_pair_impulses = false;  // sum up what each pair of bodies does into `pair_impulses`
  std::vector<PairImpulse> pair_impulses;  // ordered by (body_a, body_b)

  BroadPhase broad_phase;
  Islands islands;
  StepWorkspace work;
  std::unique_ptr<Workers> workers;  // when settings.threads > 1 and there was work to share

  double time() const { return static_cast<double>(step_count) * settings.dt; }
};

struct DivergedInfo {
  std::uint64_t step = 0;
  std::int32_t body = -1;
};

// What a step throws when a state stops being finite; the world keeps the last good state.
class Diverged : public std::exception {
 public:
  Diverged(std::uint64_t step, std::int32_t body) : info{step, body} {}
  const char* what() const noexcept override { return "a body state stopped being finite"; }
  DivergedInfo info;
};

// world/bodies.cpp
std::int32_t add_body(World& world, Body body, const Shape& shape);
void remove_body(World& world, std::int32_t row);

// world/step.cpp
void step(World& world);

// world/detect.cpp
void detect_contacts(World& world);

// world/snapshot.cpp
std::uint64_t state_hash(const World& world);
std::vector<std::uint8_t> save(const World& world);
void restore(World& world, const std::uint8_t* data,
             std::size_t size);  // throws std::invalid_argument

}  // namespace rb
