#include "solver/block_gauss_seidel.hpp"

#include <algorithm>
#include <cmath>

#include "math/rotation.hpp"
#include "solver/contact_operators.hpp"
#include "solver/local_solver.hpp"

namespace rb {
namespace {

Mat3 cross_matrix(const Vec3& r) {
  Mat3 m;
  m << 0.0, -r[2], r[1], r[2], 0.0, -r[0], -r[1], r[0], 0.0;
  return m;
}

Mat3 point_inverse_mass(const ContactProblem& p, int body, const Vec3& r) {
  const Mat3 c = cross_matrix(r);
  Mat3 m = -(c * p.inv_inertia[body] * c);
  m.diagonal().array() += p.inv_mass[body];
  return m;
}

}  // namespace

double solve_local_moment(const ContactProblem& p, const ContactConstraint& c,
                          const FrictionCone& cone, const Mat3& w, double normal, Vec3& moment,
                          std::vector<Vec6>& v) {
  Vec3 x = moment / cone.length;
  const Vec3 slip = cone.length * relative_spin(c, v);
  const Vec3 q = slip - w * x;
  // Spin about n.
  const double bound_spin = cone.spin * normal;
  Vec3 y = x;
  if (w(0, 0) > 0.0) {
    y[0] = std::clamp(-(q[0] + w(0, 1) * y[1] + w(0, 2) * y[2]) / w(0, 0), -bound_spin, bound_spin);
  }
  if (w(1, 1) > 0.0 && w(2, 2) > 0.0) {
    y.tail<2>() = solve_local_slip(w.bottomRightCorner<2, 2>(),
                                   q.tail<2>() + w.block<2, 1>(1, 0) * y[0], cone.roll * normal);
  }
  const Vec3 delta = cone.length * (y - x);
  moment += delta;
  apply_moment(p, c, delta, v);
  return (w * (y - x)).norm();
}

void local_delassus(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                    GaussSeidelWorkspace& ws) {
  const std::size_t nc = problem.contacts.size();
  ws.w.resize(nc);
  ws.w_angular.resize(nc);
  for (std::size_t i = 0; i < nc; ++i) {
    const ContactConstraint& c = problem.contacts[i];
    Mat3 w = point_inverse_mass(problem, c.a, c.r_a);
    if (c.b >= 0) w += point_inverse_mass(problem, c.b, c.r_b);
    ws.w[i] = c.frame * w * c.frame.transpose();
    if (!cones[i].has_moment()) continue;
    Mat3 angular = problem.inv_inertia[c.a];
    if (c.b >= 0) angular += problem.inv_inertia[c.b];
    ws.w_angular[i] = cones[i].length * cones[i].length * c.frame * angular * c.frame.transpose();
  }
}

double gauss_seidel_sweep(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                          const GaussSeidelWorkspace& ws, std::vector<Vec3>& impulse,
                          std::vector<Vec3>& moment, std::vector<Vec6>& v) {
  double change = 0.0;
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const ContactConstraint& c = problem.contacts[i];
    const Vec3 q = relative_velocity(c, v) - ws.w[i] * impulse[i];
    const Vec3 next = solve_local_contact(ws.w[i], q, cones[i].slide);
    const Vec3 delta = next - impulse[i];
    impulse[i] = next;
    apply_impulse(problem, c, delta, v);
    change = std::max(change, (ws.w[i] * delta).norm());
    if (cones[i].has_moment()) {
      change = std::max(
          change, solve_local_moment(problem, c, cones[i], ws.w_angular[i], next[0], moment[i], v));
    }
  }
  return change;
}

}  // namespace rb
