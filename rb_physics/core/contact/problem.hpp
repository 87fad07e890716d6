// The contact problem in numbers: what a solver gets and what it gives back. No bodies, no shapes.
//
// Problem, in the contact frame (n, t1, t2) of every contact i, N from B to A:
//   u = J v + bias           relative velocity (A minus B) at the contact, m/s, size 3 nc
//   v = v_free + M^-1 J^T lambda
//   K_i*  contains  u_i + mu_i |u_i,t| n   orthogonal to   lambda_i  in  K_i = {|lambda_t| <= mu
//   lambda_n}
// (Coulomb with De Saxce's correction; mu = 0 leaves the LCP 0 <= u_n, lambda_n >= 0.)
// Impulses on A are +lambda, on B -lambda, N s.
#pragma once

#include <cstdint>
#include <vector>

#include "math/types.hpp"

namespace rb {

struct ContactConstraint {
  std::int32_t a = -1;      // index into the problem's bodies; A is always dynamic
  std::int32_t b = -1;      // the same, or -1: static or kinematic (its velocity sits in bias)
  Vec3 r_a = Vec3::Zero();  // m, centre of mass of A -> contact point, world
  Vec3 r_b = Vec3::Zero();  // m, the same for B; unused when b = -1
  Mat3 frame = Mat3::Identity();     // rows n, t1, t2: world -> contact frame
  Vec3 bias = Vec3::Zero();          // m/s, contact frame
  Vec3 angular_bias = Vec3::Zero();  // rad/s, contact frame: minus the spin of a kinematic B
  double friction = 0.0;             // kinetic coefficient mu >= 0
  double static_friction = 0.0;   // bound while sticking (if > friction); set it to 0 for a contact
                                  // that already slid when the step began
  double rolling_friction = 0.0;  // m, bound on |rolling moment impulse| / lambda_n
  double spinning_friction = 0.0;  // m, bound on |spinning moment impulse| / lambda_n
  double restitution = 0.0;        // epsilon in [0, 1], used by the impact laws
};

struct ContactProblem {
  std::vector<double> inv_mass;   // 1/kg, size nb
  std::vector<Mat3> inv_inertia;  // 1/(kg m^2), world axes (S4), size nb
  std::vector<Vec6> velocity;     // v_free: linear m/s, angular rad/s, world axes, size nb
  std::vector<ContactConstraint> contacts;  // size nc
};

inline constexpr int most_vain_searches = 16;

struct ContactSolution {
  std::vector<Vec3>
      impulse;  // N s, contact frame (n, t1, t2), size nc; in: warm start, out: answer
  std::vector<Vec3>
      moment;  // N m s, contact frame: (spinning, rolling t1, rolling t2), size nc or 0
  std::vector<Vec6> velocity;  // v, size nb
  // Certificate of the minimum norm, per body, size nb (in: warm start, may be empty; out: answer,
  // zero when unknown): contact forces that are not unique are lambda_i = P_Fi(J_i y), F_i the face
  // of K_i that the slip leaves.
  std::vector<Vec6> certificate;
  // How often in a row it was looked for in vain (balls that are wedged may need an infinite one);
  // at most_vain_searches the warm start's impulses will do. In: of the warm start; out: of the
  // answer.
  int vain_searches = 0;
  double residual = 0.0;  // natural map, relative (solver/residual.hpp)
  int iterations = 0;
  bool converged = true;      // residual <= the tolerance asked for
  bool minimum_norm = false;  // the impulses are the least of all that solve the problem
};

}  // namespace rb
