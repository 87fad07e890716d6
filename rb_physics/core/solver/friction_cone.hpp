// The cone of a contact's reaction (impulse; moment) and the maps the solvers need of it.
//
//   K = { lambda_n >= 0, |lambda_t| <= slide lambda_n, |m_n| <= spin lambda_n, |m_t| <= roll
//   lambda_n }
//
// Moments enter divided by `length` (spins multiplied by it), so that all six components are N s
// (m/s) and all coefficients are numbers. Components: force (n, t1, t2), moment (n, t1, t2).
#pragma once

#include <algorithm>
#include <vector>

#include "contact/problem.hpp"

namespace rb {

struct FrictionCone {
  double slide = 0.0;
  double spin = 0.0;
  double roll = 0.0;
  double length = 1.0;  // m

  bool has_moment() const { return spin > 0.0 || roll > 0.0; }
};

struct Reaction {
  Vec3 force = Vec3::Zero();
  Vec3 moment = Vec3::Zero();
};

// A face of K: components that slip keep the direction opposite to the slip, at the bound.
struct ConeFace {
  bool open = false;  // the face {0}: contact opens
  bool slides = false, spins = false, rolls = false;
  Vec2 slide_direction = Vec2::Zero();  // of the slip, unit
  double spin_direction = 0.0;          // +1 or -1
  Vec2 roll_direction = Vec2::Zero();   // unit
};

// Derivative of a map of reactions; moment blocks are set only if the cone has moments.
struct ReactionDerivative {
  Mat3 ff = Mat3::Zero(), fm = Mat3::Zero(), mf = Mat3::Zero(), mm = Mat3::Zero();
};

// Orthogonal projection on the cone of a force alone, |a_t| <= mu a_n, in closed form: what nearly
// all contacts are. `d` (may be null) gets a generalised Jacobian, symmetric.
[[gnu::always_inline]] inline Vec3 project_on_plain_cone(double mu, const Vec3& a, Mat3* d) {
  const double size = a.tail<2>().norm();
  if (a[0] > 0.0 && size <= mu * a[0]) {
    if (d != nullptr) d->setIdentity();
    return a;
  }
  const double n = (a[0] + mu * size) / (1.0 + mu * mu);
  if (!(n > 0.0)) {
    if (d != nullptr) d->setZero();
    return Vec3::Zero();
  }
  Vec3 ray(1.0, 0.0, 0.0);
  if (size > 0.0) ray.tail<2>() = (mu / size) * a.tail<2>();
  if (d != nullptr) {
    *d = (ray * ray.transpose()) / (1.0 + mu * mu);
    if (mu > 0.0) {
      const Vec2 e = a.tail<2>() / size;
      d->bottomRightCorner<2, 2>() +=
          (mu * n / size) * (Eigen::Matrix2d::Identity() - e * e.transpose());
    }
  }
  return n * ray;
}

// Orthogonal projection on K, or on one of its faces. Exact; `d` (may be null) gets a generalised
// Jacobian, symmetric.
Reaction project_on_cone(const FrictionCone& cone, const Reaction& a, ReactionDerivative* d);
Reaction project_on_face(const FrictionCone& cone, const ConeFace& face, const Reaction& a,
                         ReactionDerivative* d);

// Alart & Curnier 1991: lambda_n = max(0, a_n), every other component cut at its bound for that
// lambda_n. Fixed points of a = lambda - rho u are Coulomb's law itself, without De Saxce's term.
// The Jacobian is not symmetric where a component is cut.
Reaction alart_curnier_map(const FrictionCone& cone, const Reaction& a, ReactionDerivative* d);

// De Saxce & Feng 1998: the slip u with slide |u_t| + spin |w_n| + roll |w_t| added to u_n.
Reaction de_saxce(const FrictionCone& cone, const Reaction& slip);

// Cones of all contacts with the kinetic (or static) coefficient.
enum class Friction { kKinetic, kStatic };
FrictionCone cone_with_moments(const ContactProblem& problem, const ContactConstraint& c,
                               double slide);
inline FrictionCone friction_cone(const ContactProblem& problem, const ContactConstraint& c,
                                  Friction which) {
  const double slide =
      which == Friction::kStatic ? std::max(c.static_friction, c.friction) : c.friction;
  if (c.spinning_friction > 0.0 || c.rolling_friction > 0.0)
    return cone_with_moments(problem, c, slide);
  return {slide, 0.0, 0.0, 1.0};
}
void friction_cones(const ContactProblem& problem, Friction which, std::vector<FrictionCone>& out);

}  // namespace rb
