// THE residual: one function judges every solver and every test.
//
// Natural map of the cone complementarity problem with De Saxce's correction,
//   r_i = lambda_i - P_Ki(lambda_i - rho_i (u_i + mu_i |u_i,t| n)),   rho_i = 1 / w_i,
// w_i = trace(W_ii)/3, in velocity units w_i r_i, and relative to the problem's typical velocity
//   U = max_i max(w_i |lambda_i|, -u_free,i,n, 3.6e-6 s_i):
// the largest change of velocity that an impulse makes or is asked to make. So the residual has no
// unit and does not depend on mass or size. Zero means: solved. The last term, with s_i the speeds
// of both bodies' surfaces at the contact, only counts where nothing else does (balls that fly
// along in touch): 1e-8 of it is 160 roundings of the speed, below which no slip is known.
#pragma once

#include <vector>

#include "contact/problem.hpp"
#include "solver/friction_cone.hpp"

namespace rb {

struct ContactResidual {
  double natural_map = 0.0;     // max_i |w_i r_i| / U
  double typical_velocity = 0;  // U, m/s
};

// The judge: velocities are computed anew from the impulses. A contact whose static coefficient is
// larger is judged by it while its slip is below `kStickSlip` of U, by the kinetic one otherwise.
// Throws std::invalid_argument if sizes do not fit.
double natural_map_residual(const ContactProblem& problem, const ContactSolution& solution);

inline constexpr double kStickSlip = 1e-8;

// What the residual needs of a problem whatever the impulses are.
struct ContactScales {
  std::vector<double> w;      // 1/kg
  std::vector<double> speed;  // m/s, max(-u_free,n, 3.6e-6 s)
  double least_w = 0.0;       // 1/kg, of all contacts
};
void contact_scales(const ContactProblem& problem, ContactScales& scales);

// The same for given cones and velocities v = v_free + M^-1 J^T lambda. Used inside the solvers.
// `slips` (may be null) get what it is made of: u of every contact, m/s.
ContactResidual natural_map_residual(const ContactProblem& problem, const ContactScales& scales,
                                     const std::vector<FrictionCone>& cones,
                                     const std::vector<Vec3>& impulse,
                                     const std::vector<Vec3>& moment, const std::vector<Vec6>& v,
                                     std::vector<Vec3>* slips = nullptr);

// Relative size of the rounding in u = J v: no solver can promise a residual below it.
double rounding_floor(const ContactProblem& problem, const std::vector<Vec6>& v,
                      double typical_velocity);

}  // namespace rb
