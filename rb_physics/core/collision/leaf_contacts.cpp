#include "collision/leaf_contacts.hpp"

#include <array>
#include <stdexcept>
#include <string>

#include "collision/pairs.hpp"

namespace rb {

namespace {

using ContactFunction = void (*)(const Shape&, const Placement&, const Shape&, const Placement&,
                                 double, Manifold&);

// What a pair function takes, out of a Shape that holds a T.
template <class T>
const T& as(const Shape& shape) {
  return *std::get_if<T>(&shape);
}
template <class T>
struct Argument {
  static const T& of(const Shape& shape) { return as<T>(shape); }
};
template <>
struct Argument<Particle> {
  static Ball of(const Shape&) { return {0.0, true}; }
};
template <>
struct Argument<Sphere> {
  static Ball of(const Shape& shape) { return {as<Sphere>(shape).radius, false}; }
};

template <class A, class B, auto function>
void call(const Shape& a, const Placement& at_a, const Shape& b, const Placement& at_b,
          double margin, Manifold& out) {
  function(Argument<A>::of(a), at_a, Argument<B>::of(b), at_b, margin, out);
}

template <class T, std::size_t i = 0>
constexpr std::size_t index_of() {
  if constexpr (std::is_same_v<std::variant_alternative_t<i, Shape>, T>) {
    return i;
  } else {
    return index_of<T, i + 1>();
  }
}

constexpr std::size_t types = std::variant_size_v<Shape>;
using Table = std::array<std::array<ContactFunction, types>, types>;

Table make_table() {
  Table table{};
  const auto set = [&]<class A, class B, auto function>() {
    table[index_of<A>()][index_of<B>()] = &call<A, B, function>;
  };
  set.operator()<Particle, Particle, contacts_ball_ball>();
  set.operator()<Particle, Sphere, contacts_ball_ball>();
  set.operator()<Sphere, Sphere, contacts_ball_ball>();
  set.operator()<Particle, Box, contacts_ball_box>();
  set.operator()<Sphere, Box, contacts_ball_box>();
  set.operator()<Particle, HalfSpace, contacts_ball_half_space>();
  set.operator()<Sphere, HalfSpace, contacts_ball_half_space>();
  set.operator()<Box, Box, contacts_box_box>();
  set.operator()<Box, HalfSpace, contacts_box_half_space>();
  set.operator()<Particle, ConvexHull, contacts_ball_hull>();
  set.operator()<Sphere, ConvexHull, contacts_ball_hull>();
  set.operator()<Box, ConvexHull, contacts_box_hull>();
  set.operator()<ConvexHull, ConvexHull, contacts_hull_hull>();
  set.operator()<ConvexHull, HalfSpace, contacts_hull_half_space>();
  set.operator()<Particle, Capsule, contacts_ball_capsule>();
  set.operator()<Sphere, Capsule, contacts_ball_capsule>();
  set.operator()<Capsule, Capsule, contacts_capsule_capsule>();
  set.operator()<Capsule, Cylinder, contacts_capsule_cylinder>();
  set.operator()<Capsule, Box, contacts_capsule_box>();
  set.operator()<Capsule, ConvexHull, contacts_capsule_hull>();
  set.operator()<Capsule, HalfSpace, contacts_capsule_half_space>();
  set.operator()<Particle, Cylinder, contacts_ball_cylinder>();
  set.operator()<Sphere, Cylinder, contacts_ball_cylinder>();
  set.operator()<Cylinder, Cylinder, contacts_cylinder_cylinder>();
  set.operator()<Cylinder, Box, contacts_cylinder_box>();
  set.operator()<Cylinder, ConvexHull, contacts_cylinder_hull>();
  set.operator()<Cylinder, HalfSpace, contacts_cylinder_half_space>();
  return table;
}

}  // namespace

void leaf_contacts(const Shape& a, const Placement& at_a, const Shape& b, const Placement& at_b,
                   double margin, Manifold& out) {
  static const Table table = make_table();
  const ContactFunction function = table[a.index()][b.index()];
  if (function == nullptr) {
    throw std::invalid_argument(std::string("contacts between ") + shape_name(a) + " and " +
                                shape_name(b) + " are not available");
  }
  function(a, at_a, b, at_b, margin, out);
}

}  // namespace rb
