#include "solver/residual.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "solver/contact_operators.hpp"

namespace rb {
namespace {

// |w lambda - P_K(w lambda - u~)|^2; K is a cone, so that scaling by w commutes with P_K.
double natural_map_sq(const FrictionCone& cone, double w, const Reaction& reaction,
                      const Reaction& slip) {
  const Reaction s = de_saxce(cone, slip);
  const Reaction at{w * reaction.force - s.force, w * reaction.moment - s.moment};
  const Reaction p = project_on_cone(cone, at, nullptr);
  return (w * reaction.force - p.force).squaredNorm() +
         (w * reaction.moment - p.moment).squaredNorm();
}

// The same of a force alone.
double natural_map_sq(double mu, double w, const Vec3& impulse, Vec3 slip) {
  slip[0] += mu * slip.tail<2>().norm();
  const Vec3 scaled = w * impulse;
  return (scaled - project_on_plain_cone(mu, scaled - slip, nullptr)).squaredNorm();
}

// The same without friction, where K is the half-line of pushes.
double natural_map_sq(double w, const Vec3& impulse, const Vec3& slip) {
  const Vec3 at = w * impulse;
  const double normal = at[0] - std::max(0.0, at[0] - slip[0]);
  return normal * normal + at.tail<2>().squaredNorm();
}

Reaction reaction_of(const FrictionCone& cone, const std::vector<Vec3>& impulse,
                     const std::vector<Vec3>& moment, std::size_t i) {
  Reaction r;
  r.force = impulse[i];
  if (!moment.empty()) r.moment = moment[i] / cone.length;
  return r;
}

// Of the bodies' own speeds. Slips round to some 16 epsilon of them; measured by anything smaller
// than this, that rounding alone would read as more than 1e-9.
constexpr double kNoise = 16.0 * std::numeric_limits<double>::epsilon() / 1e-9;

double typical_velocity(const ContactScales& scales, const std::vector<Vec3>& impulse) {
  double u = 0.0;
  for (std::size_t i = 0; i < impulse.size(); ++i) {
    u = std::max({u, scales.w[i] * impulse[i].norm(), scales.speed[i]});
  }
  return u;
}

void check_sizes(const ContactProblem& p, const ContactSolution& s) {
  const std::size_t nc = p.contacts.size();
  if (s.impulse.size() != nc) {
    throw std::invalid_argument("natural_map_residual: impulse has " +
                                std::to_string(s.impulse.size()) + " entries for " +
                                std::to_string(nc) + " contacts");
  }
  if (!s.moment.empty() && s.moment.size() != nc) {
    throw std::invalid_argument("natural_map_residual: moment has " +
                                std::to_string(s.moment.size()) + " entries for " +
                                std::to_string(nc) + " contacts (or none)");
  }
}

}  // namespace

double natural_map_residual(const ContactProblem& problem, const ContactSolution& solution) {
  check_sizes(problem, solution);
  std::vector<Vec6> v;
  velocity_from_impulses(problem, solution.impulse, solution.moment, v);
  ContactScales scales;
  contact_scales(problem, scales);
  const double scale = typical_velocity(scales, solution.impulse);
  std::vector<FrictionCone> cones;
  friction_cones(problem, Friction::kKinetic, cones);
  for (std::size_t i = 0; i < cones.size(); ++i) {
    const ContactConstraint& c = problem.contacts[i];
    if (c.static_friction > c.friction &&
        relative_velocity(c, v).tail<2>().norm() <= kStickSlip * scale) {
      cones[i].slide = c.static_friction;
    }
  }
  return natural_map_residual(problem, scales, cones, solution.impulse, solution.moment, v)
      .natural_map;
}

void contact_scales(const ContactProblem& problem, ContactScales& scales) {
  const std::size_t nc = problem.contacts.size();
  scales.w.resize(nc);
  scales.speed.resize(nc);
  scales.least_w = std::numeric_limits<double>::infinity();
  SurfaceSpeed speed_a(problem.velocity), speed_b(problem.velocity);
  for (std::size_t i = 0; i < nc; ++i) {
    const ContactConstraint& c = problem.contacts[i];
    scales.w[i] = inverse_effective_mass(problem, c);
    const double of_b = c.b < 0 ? 0.0 : speed_b(c.b, c.r_b);
    const double noise = kNoise * (speed_a(c.a, c.r_a) + of_b);
    scales.speed[i] = std::max(-relative_velocity(c, problem.velocity)[0], noise);
    scales.least_w = std::min(scales.least_w, scales.w[i]);
  }
}

ContactResidual natural_map_residual(const ContactProblem& problem, const ContactScales& scales,
                                     const std::vector<FrictionCone>& cones,
                                     const std::vector<Vec3>& impulse,
                                     const std::vector<Vec3>& moment, const std::vector<Vec6>& v,
                                     std::vector<Vec3>* slips) {
  double worst = 0.0;
  ContactResidual result;
  if (slips != nullptr) slips->resize(problem.contacts.size());
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const ContactConstraint& c = problem.contacts[i];
    const FrictionCone& cone = cones[i];
    const Vec3 slip = relative_velocity(c, v);
    if (slips != nullptr) (*slips)[i] = slip;
    const double sq = cone.has_moment()
                          ? natural_map_sq(cone, scales.w[i], reaction_of(cone, impulse, moment, i),
                                           {slip, cone.length * relative_spin(c, v)})
                      : cone.slide > 0.0 ? natural_map_sq(cone.slide, scales.w[i], impulse[i], slip)
                                         : natural_map_sq(scales.w[i], impulse[i], slip);
    if (!(sq <= worst)) worst = sq;  // keeps NaN
  }
  worst = std::sqrt(worst);
  result.typical_velocity = typical_velocity(scales, impulse);
  const double scale = result.typical_velocity;
  if (worst == 0.0) {
    result.natural_map = 0.0;
  } else {
    result.natural_map = scale > 0.0 ? worst / scale : std::numeric_limits<double>::infinity();
  }
  return result;
}

double rounding_floor(const ContactProblem& problem, const std::vector<Vec6>& v,
                      double typical_velocity) {
  double operand = 0.0;
  SurfaceSpeed speed_a(v), speed_b(v);
  for (const ContactConstraint& c : problem.contacts) {
    operand = std::max(operand, speed_a(c.a, c.r_a));
    if (c.b >= 0) operand = std::max(operand, speed_b(c.b, c.r_b));
  }
  if (!(typical_velocity > 0.0)) return 0.0;
  return 16.0 * std::numeric_limits<double>::epsilon() * operand / typical_velocity;
}

}  // namespace rb
