// Whether a contact problem is well formed.
#include <cmath>
#include <stdexcept>
#include <string>

#include "solver/contact_solver.hpp"

namespace rb {

namespace {

void require(bool ok, std::size_t contact, const char* field, const char* allowed) {
  if (ok) return;
  throw std::invalid_argument("contact " + std::to_string(contact) + ": " + field + " must be " +
                              allowed);
}

}  // namespace

void check_problem(const ContactProblem& problem) {
  const int nb = static_cast<int>(problem.inv_mass.size());
  if (problem.inv_inertia.size() != problem.inv_mass.size() ||
      problem.velocity.size() != problem.inv_mass.size()) {
    throw std::invalid_argument("inv_mass, inv_inertia and velocity differ in length");
  }
  for (int i = 0; i < nb; ++i) {
    if (!(problem.inv_mass[i] > 0.0) || !std::isfinite(problem.inv_mass[i]) ||
        !problem.inv_inertia[i].allFinite() || !problem.velocity[i].allFinite()) {
      throw std::invalid_argument("body " + std::to_string(i) +
                                  ": inv_mass must be > 0 and all numbers finite");
    }
  }
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const ContactConstraint& c = problem.contacts[i];
    require(c.a >= 0 && c.a < nb, i, "a", "the index of a body");
    require(c.b >= -1 && c.b < nb && c.b != c.a, i, "b", "the index of another body, or -1");
    require(c.r_a.allFinite() && c.r_b.allFinite() && c.frame.allFinite(), i, "geometry", "finite");
    require(c.bias.allFinite() && c.angular_bias.allFinite(), i, "bias", "finite");
    require(c.friction >= 0.0 && c.static_friction >= 0.0 && c.rolling_friction >= 0.0 &&
                c.spinning_friction >= 0.0 &&
                std::isfinite(c.friction + c.static_friction + c.rolling_friction +
                              c.spinning_friction),
            i, "friction", "finite and >= 0");
    require(c.restitution >= 0.0 && c.restitution <= 1.0, i, "restitution", "in [0, 1]");
  }
}

}  // namespace rb
