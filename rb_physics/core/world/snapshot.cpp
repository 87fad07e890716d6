// Save, restore, and the state hash. All three walk the same fields in the same order, so that
// nothing that influences the future can be in one and missing in another.
#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "math/hash.hpp"
#include "world/world.hpp"

namespace rb {
namespace {

constexpr std::uint64_t magic = 0x32305350414e5352ULL;  // "RSNAPS02"

class Writer {
 public:
  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_trivially_copyable_v<T> &&
                  (std::is_arithmetic_v<T> || std::is_enum_v<T>));
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(&value);
    data.insert(data.end(), bytes, bytes + sizeof(T));
  }
  std::vector<std::uint8_t> data;
};

class Reader {
 public:
  Reader(const std::uint8_t* data, std::size_t size) : data_(data), end_(data + size) {}
  template <class T>
  void operator()(T& value) {
    if (static_cast<std::size_t>(end_ - data_) < sizeof(T))
      throw std::invalid_argument("snapshot: it is cut short");
    std::memcpy(&value, data_, sizeof(T));
    data_ += sizeof(T);
  }
  bool done() const { return data_ == end_; }
  std::size_t left() const { return static_cast<std::size_t>(end_ - data_); }

 private:
  const std::uint8_t* data_;
  const std::uint8_t* end_;
};

class Hasher {
 public:
  template <class T>
  void operator()(const T& value) {
    if constexpr (std::is_floating_point_v<T>)
      hash.add(value);
    else
      hash.add(static_cast<std::uint64_t>(value));
  }
  Hash hash;
};

// Fields of the parts, for a Writer, a Reader or a Hasher.
template <class V, class M>
void matrix(V& visit, M& m) {
  for (int i = 0; i < static_cast<int>(m.size()); ++i) visit(m.data()[i]);
}

template <class V, class S>
void state_fields(V& visit, S& s) {
  matrix(visit, s.x);
  matrix(visit, s.q.coeffs());
  matrix(visit, s.p);
  matrix(visit, s.L);
}

template <class V, class W>
void wrench_fields(V& visit, W& w) {
  visit(w.source);
  visit(w.frame);
  visit(w.at_center);
  matrix(visit, w.force);
  matrix(visit, w.torque);
  matrix(visit, w.point);
  visit(w.remaining);
}

template <class V, class C>
void contact_fields(V& visit, C& c) {
  visit(c.body_a);
  visit(c.body_b);
  visit(c.collider_a);
  visit(c.collider_b);
  matrix(visit, c.point.point_a);
  matrix(visit, c.point.point_b);
  matrix(visit, c.point.normal);
  visit(c.point.separation);
  visit(c.point.feature);
  visit(c.point.kind);
  visit(c.point.normal_owner);
  matrix(visit, c.local_a);
  matrix(visit, c.local_b);
  matrix(visit, c.impulse);
  matrix(visit, c.moment_a);
  matrix(visit, c.moment_b);
  visit(c.role);
  matrix(visit, c.warm_force);
  matrix(visit, c.warm_moment);
  visit(c.touch);
  visit(c.state);
}

template <class V, class B>
void body_fields(V& visit, B& b) {
  state_fields(visit, b.state);
  matrix(visit, b.velocity);
  matrix(visit, b.spin);
  visit(b.stop_after_target);
  matrix(visit, b.certificate);
  visit(b.vain_searches);
  matrix(visit, b.contact_impulse);
  matrix(visit, b.contact_moment);
}

// A container's length, then its elements.
template <class V, class Container, class Field>
void sequence(V& visit, Container& items, Field field) {
  std::uint64_t n = items.size();
  visit(n);
  if constexpr (std::is_same_v<V, Reader>) {
    if (n > visit.left()) throw std::invalid_argument("snapshot: a length in it is not possible");
    items.resize(n);
  }
  for (auto& item : items) field(visit, item);
}

template <class V, class W>
void world_fields(V& visit, W& world) {
  visit(world.step_count);
  visit(world.geometry_dirty);
  for (auto& body : world.bodies) {
    body_fields(visit, body);
    bool has_target = body.target.has_value();
    visit(has_target);
    if constexpr (std::is_same_v<V, Reader>) {
      body.target.reset();
      if (has_target) body.target.emplace();
    }
    if (has_target) {
      matrix(visit, body.target->position);
      matrix(visit, body.target->orientation.coeffs());
    }
    sequence(visit, body.wrenches, [](auto& v, auto& w) { wrench_fields(v, w); });
    if (!world.settings.sleeping) continue;
    visit(body.asleep);
    visit(body.still_time);
  }
  for (auto& t : world.travel) visit(t);
  sequence(visit, world.contacts, [](auto& v, auto& c) { contact_fields(v, c); });
}

// What must agree between the world that saved and the one that restores.
std::uint64_t fingerprint(const World& world) {
  Hasher h;
  for (const Body& b : world.bodies) {
    h(static_cast<std::uint64_t>(b.type));
    h(b.inertia.mass);
    matrix(h, b.inertia.body);
    matrix(h, b.center_of_mass);
  }
  h(static_cast<std::uint64_t>(world.colliders.size()));
  if (world.settings.sleeping) h(true);  // snapshots then hold sleep timers
  return h.hash.value();
}

}  // namespace

std::uint64_t state_hash(const World& world) {
  Hasher h;
  world_fields(h, world);
  return h.hash.value();
}

std::vector<std::uint8_t> save(const World& world) {
  Writer w;
  w(magic);
  w(static_cast<std::uint64_t>(world.bodies.size()));
  w(fingerprint(world));
  world_fields(w, world);
  // Not part of the state's future, but of what readers still have to collect.
  for (const Body& b : world.bodies) {
    matrix(w, b.contact_impulse_sum);
    matrix(w, b.contact_moment_sum);
  }
  return std::move(w.data);
}

void restore(World& world, const std::uint8_t* data, std::size_t size) {
  Reader r(data, size);
  std::uint64_t found_magic = 0;
  std::uint64_t count = 0;
  std::uint64_t print = 0;
  r(found_magic);
  if (found_magic != magic)
    throw std::invalid_argument("snapshot: these bytes are not a snapshot of this version");
  r(count);
  r(print);
  if (count != world.bodies.size() || print != fingerprint(world)) {
    throw std::invalid_argument("snapshot: it is of another world: " + std::to_string(count) +
                                " bodies, here " + std::to_string(world.bodies.size()) +
                                ", or other masses and shapes");
  }
  // Read into copies first: a bad snapshot must not leave a torn world.
  World copy_of_state;
  copy_of_state.settings = world.settings;
  copy_of_state.bodies = world.bodies;
  copy_of_state.travel = world.travel;
  world_fields(r, copy_of_state);
  for (Body& b : copy_of_state.bodies) {
    matrix(r, b.contact_impulse_sum);
    matrix(r, b.contact_moment_sum);
  }
  if (!r.done()) throw std::invalid_argument("snapshot: there is more in it than this world needs");
  const auto colliders = static_cast<std::int32_t>(world.colliders.size());
  for (Contact& c : copy_of_state.contacts) {
    if (c.collider_a < 0 || c.collider_b < 0 || c.collider_a >= colliders ||
        c.collider_b >= colliders || world.colliders[c.collider_a].body != c.body_a ||
        world.colliders[c.collider_b].body != c.body_b) {
      throw std::invalid_argument("snapshot: a contact in it names a body that is not there");
    }
    c.material = combine(world.bodies[c.body_a].material, world.bodies[c.body_b].material,
                         world.settings.friction_combine, world.settings.restitution_combine);
  }
  world.pair_impulses.clear();
  world.step_count = copy_of_state.step_count;
  world.geometry_dirty = copy_of_state.geometry_dirty;
  world.bodies = std::move(copy_of_state.bodies);
  world.travel = std::move(copy_of_state.travel);
  world.contacts = std::move(copy_of_state.contacts);
  world.work.persistent.forget();
  world.work.islands_known = false;
}

}  // namespace rb
