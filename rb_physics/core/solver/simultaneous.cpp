#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "solver/contact_operators.hpp"
#include "solver/lcp.hpp"
#include "solver/normal_delassus.hpp"
#include "solver/normal_impact.hpp"

namespace rb {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// S14 in units that make A and d_dot of order one:
//   minimise |A f + b|^2,  f >= 0,  A f + d >= 0,  f . (A f + 2 d) <= 0.
// With multipliers p >= 0, q >= 0, nu >= 0:  2 A (A f + b) + 2 nu (A f + d) = p + A q.
struct LeastSquares {
  MatrixXd a;
  VectorXd b, d;
  int pivots = 0;

  double energy(const VectorXd& f) const { return f.dot(a * f + 2.0 * d); }

  // For a given nu: a monotone LCP in (f, q).
  bool solve(double nu, VectorXd& f, VectorXd& q) {
    const Index n = d.size();
    MatrixXd m = MatrixXd::Zero(2 * n, 2 * n);
    VectorXd r(2 * n);
    m.topLeftCorner(n, n) = 2.0 * (a * a + nu * a);
    m.topRightCorner(n, n) = -a;
    m.bottomLeftCorner(n, n) = a;
    r.head(n) = 2.0 * (a * b + nu * d);
    r.tail(n) = d;
    const LcpResult lcp = lcp_lemke(m, r);
    pivots += lcp.pivots;
    f = lcp.z.head(n);
    q = lcp.z.tail(n);
    return lcp.solved;
  }

  // Newton on the KKT equations of the active sets found: from Lemke's rounding to ours.
  void polish(double nu, bool at_energy_bound, VectorXd& f, VectorXd& q) const {
    const Index n = d.size();
    std::vector<Index> carry, tight;
    const double tiny_f = 1e-9 * std::max(f.maxCoeff(), 1e-300);
    const double tiny_q = 1e-9 * std::max(q.maxCoeff(), 1e-9);
    for (Index i = 0; i < n; ++i) {
      if (f[i] > tiny_f) carry.push_back(i);
      if (q[i] > tiny_q) tight.push_back(i);
    }
    const Index nf = static_cast<Index>(carry.size());
    const Index nq = static_cast<Index>(tight.size());
    const Index size = nf + nq + (at_energy_bound ? 1 : 0);
    if (nf == 0) return;
    VectorXd x = VectorXd::Zero(n), y = VectorXd::Zero(n);
    x(carry) = f(carry);
    y(tight) = q(tight);
    VectorXd best = x;
    double best_norm = -1.0;
    for (int k = 0; k < 6; ++k) {
      const VectorXd speed = a * x + d;
      const VectorXd gradient = 2.0 * a * (a * x + b) + 2.0 * nu * speed - a * y;
      VectorXd r = VectorXd::Zero(size);
      r.head(nf) = gradient(carry);
      r.segment(nf, nq) = speed(tight);
      if (at_energy_bound) r[size - 1] = energy(x);
      const double norm = r.norm();
      if (best_norm < 0.0 || norm < best_norm) {
        best_norm = norm;
        best = x;
      }
      if (norm == 0.0) break;
      MatrixXd jacobian = MatrixXd::Zero(size, size);
      const MatrixXd h = 2.0 * (a * a + nu * a);
      jacobian.topLeftCorner(nf, nf) = h(carry, carry);
      jacobian.block(0, nf, nf, nq) = -a(carry, tight);
      jacobian.block(nf, 0, nq, nf) = a(tight, carry);
      if (at_energy_bound) {
        jacobian.col(size - 1).head(nf) = (2.0 * speed)(carry);
        jacobian.row(size - 1).head(nf) = (2.0 * speed)(carry).transpose();
      }
      Eigen::CompleteOrthogonalDecomposition<MatrixXd> qr;
      qr.setThreshold(1e-11);
      qr.compute(jacobian);
      const VectorXd step = qr.solve(r);
      x(carry) -= step.head(nf);
      y(tight) -= step.segment(nf, nq);
      if (at_energy_bound) nu -= step[size - 1];
    }
    if (best.minCoeff() >= -1e-12 * best.cwiseAbs().maxCoeff()) f = best.cwiseMax(0.0);
  }

  VectorXd minimise() {
    VectorXd f, q, trial, trial_q;
    solve(0.0, f, q);
    const double scale = f.dot(a * f);
    if (energy(f) <= 1e-13 * scale) {
      polish(0.0, false, f, q);
      return f;
    }
    // The energy falls with nu: bracket its zero, then Illinois' regula falsi.
    double low = 0.0, e_low = energy(f);
    double high = 1.0;
    solve(high, trial, trial_q);
    double e_high = energy(trial);
    for (int k = 0; k < 60 && e_high > 0.0; ++k) {
      low = high;
      e_low = e_high;
      high *= 4.0;
      solve(high, trial, trial_q);
      e_high = energy(trial);
    }
    f = trial;
    q = trial_q;
    double nu = high;
    int side = 0;
    for (int k = 0; k < 60 && high - low > 1e-13 * high; ++k) {
      nu = (low * e_high - high * e_low) / (e_high - e_low);
      if (!(nu > low && nu < high)) nu = 0.5 * (low + high);
      solve(nu, f, q);
      const double e = energy(f);
      if (std::abs(e) <= 1e-13 * scale) break;
      if (e > 0.0) {
        low = nu;
        e_low = e;
        if (side == 1) e_high *= 0.5;
        side = 1;
      } else {
        high = nu;
        e_high = e;
        if (side == -1) e_low *= 0.5;
        side = -1;
      }
    }
    polish(nu, true, f, q);
    return f;
  }
};

// Newton's law in every contact at once, if it is the answer: all speeds as aimed at, f >= 0, no
// gain of energy. Then the least squares sum is zero. True for one body on its corners.
bool newton_law(const ContactProblem& problem, const VectorXd& before, const VectorXd& aim,
                SolverWorkspace& workspace, NormalImpact& out) {
  ContactProblem shifted = problem;
  for (Index i = 0; i < before.size(); ++i) shifted.contacts[i].bias[0] -= aim[i];
  out = inelastic_projection(shifted, problem.velocity, {}, workspace);
  if (out.capped) return false;
  const VectorXd after = normal_speeds(problem, out.velocity);
  const double scale = before.cwiseAbs().maxCoeff();
  if ((after - aim).cwiseAbs().maxCoeff() > 1e-12 * scale) return false;
  const double work = out.impulse.dot(after + before);
  return work <= 1e-13 * out.impulse.dot(after - before);
}

// Least impulses of the same total wrenches: contacts without a say share evenly.
void share_evenly(const ContactProblem& problem, SolverWorkspace& ws, NormalImpact& out) {
  const std::size_t nc = problem.contacts.size();
  std::vector<FrictionCone> cones(nc);
  if (!ws.space.prepare(problem, 1e9)) return;
  ws.minimum_norm.faces.assign(nc, ConeFace{});
  std::vector<Vec3> impulse(nc, Vec3::Zero()), moment;
  for (std::size_t i = 0; i < nc; ++i) impulse[i][0] = out.impulse[static_cast<Index>(i)];
  std::vector<Vec6> certificate;
  double w = 0.0;
  for (const ContactConstraint& c : problem.contacts) w += inverse_effective_mass(problem, c);
  w /= static_cast<double>(nc);
  const int steps = minimum_norm(problem, cones, 1e-7 * w, ws.space, ws.minimum_norm, impulse,
                                 moment, certificate);
  if (steps <= 0) return;
  for (std::size_t i = 0; i < nc; ++i) out.impulse[static_cast<Index>(i)] = impulse[i][0];
}

}  // namespace

NormalImpact simultaneous_impact(const ContactProblem& problem, SolverWorkspace& workspace) {
  NormalImpact out;
  const VectorXd before = normal_speeds(problem, problem.velocity);
  const Index nc = before.size();
  VectorXd aim = before;  // speeds after: kept if parting, reversed if approaching
  for (Index i = 0; i < nc; ++i) {
    if (before[i] < 0.0) aim[i] = -problem.contacts[i].restitution * before[i];
  }
  if (newton_law(problem, before, aim, workspace, out)) return out;

  LeastSquares s;
  const double scale_d = before.cwiseAbs().maxCoeff();
  s.a = normal_delassus(problem);
  const double scale_a = s.a.diagonal().mean();
  s.a /= scale_a;
  s.d = before / scale_d;
  s.b = (before - aim) / scale_d;
  out.impulse = s.minimise() * (scale_d / scale_a);
  out.iterations = s.pivots;
  share_evenly(problem, workspace, out);
  out.velocity = problem.velocity;
  apply_normal_impulses(problem, out.impulse, out.velocity);
  return out;
}

}  // namespace rb
