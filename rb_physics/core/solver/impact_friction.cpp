#include "solver/impact_friction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/contact_operators.hpp"
#include "solver/local_solver.hpp"
#include "solver/normal_delassus.hpp"
#include "solver/normal_impact.hpp"

namespace rb {
namespace {

constexpr int kMaxSweeps = 2000;
constexpr int kMaxRests = 4;
constexpr double kRounding = 1e-15;  // of the fastest contact: what sweeps settle to
// Corners of an edge that stick both: what their places differ by across the tangent planes asks
// for forces along the edge that have no end. Sweeps that come no nearer for so long have settled.
constexpr int kMaxStalled = 40;

double scaled_square(const Vec3& moment, const FrictionCone& cone) {
  return cone.has_moment() ? (moment / cone.length).squaredNorm() : 0.0;
}

}  // namespace

int impact_friction(const ContactProblem& problem, std::vector<Vec3>& impulse,
                    std::vector<Vec3>& moment, std::vector<Vec6>& v, SolverWorkspace& ws) {
  const std::size_t nc = problem.contacts.size();
  friction_cones(problem, Friction::kKinetic, ws.cones);
  local_delassus(problem, ws.cones, ws.gauss_seidel);
  bool any = false;
  bool moments = false;
  double fastest = 0.0;
  for (std::size_t i = 0; i < nc; ++i) {
    any = any || (impulse[i][0] > 0.0 && (ws.cones[i].slide > 0.0 || ws.cones[i].has_moment()));
    moments = moments || ws.cones[i].has_moment();
    fastest = std::max(fastest, relative_velocity(problem.contacts[i], problem.velocity).norm());
  }
  if (!any) return 0;
  moment.clear();
  if (moments) moment.assign(nc, Vec3::Zero());

  // Block Gauss-Seidel, accelerated by the nonsmooth nonlinear conjugate gradient method
  // (Silcowitz, Niebe & Erleben 2010): redundant corners of one face make plain sweeps crawl.
  int sweeps = 0;
  const bool at_once = nc == 1 && !moments;  // exact
  double last_sq = 0.0;
  double least = std::numeric_limits<double>::infinity();  // change of a sweep
  int stalled = 0;
  ws.direction.assign(nc, Vec3::Zero());
  ws.moment_direction.assign(moments ? nc : 0, Vec3::Zero());
  for (double change = 1.0; sweeps < kMaxSweeps && change > kRounding * fastest; ++sweeps) {
    change = 0.0;
    double sq = 0.0;
    ws.saved_impulse = impulse;
    ws.saved_moment = moment;
    for (std::size_t i = 0; i < nc; ++i) {
      const double bound = ws.cones[i].slide * impulse[i][0];
      if (!(impulse[i][0] > 0.0)) continue;
      const ContactConstraint& c = problem.contacts[i];
      const Eigen::Matrix2d w = ws.gauss_seidel.w[i].bottomRightCorner<2, 2>();
      const Vec2 q = relative_velocity(c, v).tail<2>() - w * impulse[i].tail<2>();
      const Vec2 next = solve_local_slip(w, q, bound);
      const Vec3 delta(0.0, next[0] - impulse[i][1], next[1] - impulse[i][2]);
      impulse[i].tail<2>() = next;
      apply_impulse(problem, c, delta, v);
      change = std::max(change, (w * delta.tail<2>()).norm());
      if (ws.cones[i].has_moment()) {
        change = std::max(change,
                          solve_local_moment(problem, c, ws.cones[i], ws.gauss_seidel.w_angular[i],
                                             impulse[i][0], moment[i], v));
      }
      sq += (impulse[i] - ws.saved_impulse[i]).squaredNorm();
      if (moments) sq += scaled_square(moment[i] - ws.saved_moment[i], ws.cones[i]);
    }
    stalled = change < 0.99 * least ? 0 : stalled + 1;
    least = std::min(least, change);
    if (at_once || stalled >= kMaxStalled || !(change > kRounding * fastest)) {
      ++sweeps;
      break;
    }
    const double beta = last_sq > 0.0 ? sq / last_sq : 0.0;
    // A plain sweep, and start again; the last one too is plain, so that all keep within bounds.
    const bool uphill = beta >= 1.0 || sweeps + 1 == kMaxSweeps;
    last_sq = uphill ? 0.0 : sq;
    for (std::size_t i = 0; i < nc; ++i) {
      const auto go_on = [&](Vec3& x, const Vec3& before, Vec3& direction) -> Vec3 {
        const Vec3 step = uphill ? Vec3::Zero() : Vec3(beta * direction);
        direction = uphill ? Vec3::Zero() : Vec3(step + (x - before));
        x += step;
        return step;
      };
      apply_impulse(problem, problem.contacts[i],
                    go_on(impulse[i], ws.saved_impulse[i], ws.direction[i]), v);
      if (moments) {
        apply_moment(problem, problem.contacts[i],
                     go_on(moment[i], ws.saved_moment[i], ws.moment_direction[i]), v);
      }
    }
  }

  int iterations = sweeps;
  ContactProblem rest = problem;
  for (ContactConstraint& c : rest.contacts) c.static_friction = 0.0;
  // Once, as a rule; again where the first answer of an ill-conditioned island leaves a little.
  for (int k = 0; k < kMaxRests; ++k) {
    if (normal_speeds(problem, v).minCoeff() >= -1e-13 * fastest) break;
    rest.velocity = v;
    ContactSolution solution;
    const SolveReport report = solve_contacts(rest, SolverSettings{}, solution, ws);
    iterations += report.sweeps + report.newton_steps;
    if (!(report.residual <= tolerance::residual_ceiling)) {  // friction out of reach: without it
      const NormalImpact last = inelastic_projection(problem, v, {}, ws);
      for (std::size_t i = 0; i < nc; ++i) impulse[i][0] += last.impulse[static_cast<int>(i)];
      v = last.velocity;
      iterations += last.iterations;
      continue;
    }
    for (std::size_t i = 0; i < nc; ++i) {
      impulse[i] += solution.impulse[i];
      if (moments) moment[i] += solution.moment[i];
    }
    v = solution.velocity;
  }
  return iterations;
}

}  // namespace rb
