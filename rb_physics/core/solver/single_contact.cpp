#include <stdexcept>

#include "solver/normal_impact.hpp"

namespace rb {

double single_contact_impulse(double d_dot, double a, double restitution) {
  if (!(d_dot < 0.0)) return 0.0;
  const double f = -(1.0 + restitution) * d_dot / a;
  // S15: below the first the bodies still approach, above the second they gain energy.
  const double rounding = 1.0 + 1e-15;
  if (!(f * rounding >= -d_dot / a && f <= -2.0 * d_dot / a * rounding)) {
    throw std::logic_error("impulse of a single contact outside -d/a <= f <= -2d/a");
  }
  return f;
}

}  // namespace rb
