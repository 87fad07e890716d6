// Surface properties of a body and how two of them combine at a contact.
#pragma once

#include <cmath>
#include <cstdint>

namespace rb {

struct Material {
  double friction = 0.5;           // kinetic coefficient, >= 0
  double static_friction = 0.5;    // >= friction; equal to it unless given
  double rolling_friction = 0.0;   // m, >= 0
  double spinning_friction = 0.0;  // m, >= 0
  double restitution = 0.0;        // in [0, 1]
};

enum class Combine : std::uint8_t { GEOMETRIC_MEAN, MEAN, MIN, MAX, PRODUCT };

inline double combine(Combine rule, double a, double b) {
  switch (rule) {
    case Combine::GEOMETRIC_MEAN:
      return a == b ? a : std::sqrt(a * b);
    case Combine::MEAN:
      return 0.5 * (a + b);
    case Combine::MIN:
      return a < b ? a : b;
    case Combine::MAX:
      return a > b ? a : b;
    case Combine::PRODUCT:
      return a * b;
  }
  return a;
}

inline Material combine(const Material& a, const Material& b, Combine friction,
                        Combine restitution) {
  return {combine(friction, a.friction, b.friction),
          combine(friction, a.static_friction, b.static_friction),
          combine(friction, a.rolling_friction, b.rolling_friction),
          combine(friction, a.spinning_friction, b.spinning_friction),
          combine(restitution, a.restitution, b.restitution)};
}

}  // namespace rb
