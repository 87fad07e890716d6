#include "solver/cone_newton.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/contact_operators.hpp"
#include "solver/residual.hpp"

namespace rb {
namespace {

using Map = ConeNewtonOptions::Map;

struct Newton {
  const ContactProblem& problem;
  const std::vector<FrictionCone>& cones;
  const ConeNewtonOptions& options;
  BodySpace& space;
  ConeNewtonWorkspace& ws;
  double eps = 0.0;

  // All in increments from the outer iterate, so that rounding shrinks with them: slip u0 + J B z,
  // reaction G(anchor - u/eps), gradient z - B^T J^T (reaction - anchor); returns its norm.
  double evaluate(const std::vector<Vec6>& z, bool with_derivative) {
    space.scale(z, ws.v);
    ws.wrench.assign(z.size(), Vec6::Zero());
    for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
      const ContactConstraint& c = problem.contacts[i];
      const FrictionCone& cone = cones[i];
      Reaction a = ws.anchor[i];
      a.force -= (ws.slip[i].force + relative_motion(c, ws.v)) / eps;
      if (cone.has_moment()) {
        a.moment -= (ws.slip[i].moment + cone.length * relative_turning(c, ws.v)) / eps;
      }
      ReactionDerivative* d = with_derivative ? &ws.d[i] : nullptr;
      ws.argument[i] = a;
      ws.reaction[i] = options.map == Map::kCoulomb ? alart_curnier_map(cone, a, d)
                                                    : project_on_cone(cone, a, d);
      add_wrench(
          c, cone,
          {ws.reaction[i].force - ws.anchor[i].force, ws.reaction[i].moment - ws.anchor[i].moment},
          ws.wrench);
    }
    space.scale_transposed(ws.wrench, ws.gradient);
    double sq = 0.0;
    for (std::size_t i = 0; i < z.size(); ++i) {
      ws.gradient[i] = z[i] - ws.gradient[i];
      sq += ws.gradient[i].squaredNorm();
    }
    return std::sqrt(sq);
  }

  void start(const std::vector<Vec3>& impulse, const std::vector<Vec3>& moment,
             const std::vector<Vec6>& v) {
    ws.z.assign(problem.inv_mass.size(), Vec6::Zero());
    for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
      const ContactConstraint& c = problem.contacts[i];
      const FrictionCone& cone = cones[i];
      ws.anchor[i] = {impulse[i], Vec3::Zero()};
      ws.slip[i] = {relative_velocity(c, v), Vec3::Zero()};
      if (cone.has_moment()) {
        ws.anchor[i].moment = moment[i] / cone.length;
        ws.slip[i].moment = cone.length * relative_spin(c, v);
      }
      if (options.map == Map::kAssociated) ws.slip[i] = de_saxce(cone, ws.slip[i]);
    }
  }

  // Directional derivative of the inner energy at z + step p: exact along the line, because the
  // slips change linearly. For the Coulomb map it is the power F . p of the residual.
  double slope(double step) {
    double power = ws.zp + step * ws.pp;
    for (std::size_t i = 0; i < cones.size(); ++i) {
      Reaction a;
      a.force = ws.argument[i].force - (step / eps) * ws.slip_step[i].force;
      if (cones[i].has_moment()) {
        a.moment = ws.argument[i].moment - (step / eps) * ws.slip_step[i].moment;
      }
      const Reaction g = options.map == Map::kCoulomb ? alart_curnier_map(cones[i], a, nullptr)
                                                      : project_on_cone(cones[i], a, nullptr);
      power -= (g.force - ws.anchor[i].force).dot(ws.slip_step[i].force);
      if (cones[i].has_moment())
        power -= (g.moment - ws.anchor[i].moment).dot(ws.slip_step[i].moment);
    }
    return power;
  }

  // Step length along p = -dz: the full step unless the energy rises there again; then the zero of
  // the slope between.
  double line_search() {
    space.scale(ws.dz, ws.v);
    ws.zp = 0.0;
    ws.pp = 0.0;
    double at_zero = 0.0;
    for (std::size_t i = 0; i < ws.z.size(); ++i) {
      ws.zp -= ws.z[i].dot(ws.dz[i]);
      ws.pp += ws.dz[i].squaredNorm();
      at_zero -= ws.gradient[i].dot(ws.dz[i]);
    }
    for (std::size_t i = 0; i < cones.size(); ++i) {
      const ContactConstraint& c = problem.contacts[i];
      ws.slip_step[i].force = -relative_motion(c, ws.v);
      if (cones[i].has_moment()) {
        ws.slip_step[i].moment = cones[i].length * -relative_turning(c, ws.v);
      }
    }
    if (!(at_zero < 0.0)) return 1.0;
    double high = 1.0;
    double f_high = slope(high);
    if (f_high <= 0.1 * std::abs(at_zero)) return 1.0;
    double low = 0.0;
    double f_low = at_zero;
    double step = 1.0;
    int side = 0;
    for (int k = 0; k < 12; ++k) {
      step = (low * f_high - high * f_low) / (f_high - f_low);
      const double margin = 0.05 * (high - low);
      step = std::clamp(step, low + margin, high - margin);
      const double f = slope(step);
      if (std::abs(f) <= 0.1 * std::abs(at_zero)) break;
      if (f < 0.0) {
        low = step;
        f_low = f;
        if (side == -1) f_high *= 0.5;
        side = -1;
      } else {
        high = step;
        f_high = f;
        if (side == 1) f_low *= 0.5;
        side = 1;
      }
    }
    return step;
  }

  bool symmetric() const {
    if (options.map == Map::kAssociated) return true;
    for (std::size_t i = 0; i < cones.size(); ++i) {
      if (ws.d[i].ff(1, 0) != 0.0 || ws.d[i].ff(2, 0) != 0.0) return false;
      if (cones[i].has_moment() && !ws.d[i].mf.col(0).isZero(0.0)) return false;
    }
    return true;
  }

  // Newton on the inner problem. Returns the number of steps, negative if it did not converge.
  int inner() {
    double norm = evaluate(ws.z, true);
    const double start_norm = norm;
    int steps = 0;
    while (steps < options.max_inner && norm > 0.0) {
      if (!space.factorize(problem, cones, ws.d, 1.0 / eps, symmetric())) break;
      ws.dz = ws.gradient;
      space.solve(ws.dz);
      const double step = line_search();
      for (std::size_t i = 0; i < ws.z.size(); ++i) ws.z[i] -= step * ws.dz[i];
      const double next = evaluate(ws.z, true);
      ++steps;
      const bool rounding = next > 0.5 * norm && next < 1e-4 * start_norm;
      norm = next;
      if (norm <= options.inner_tolerance * start_norm || rounding) return steps;
      if (step < 1e-6) break;  // no way down along this direction
    }
    return norm <= 1e-2 * start_norm ? steps : -steps;
  }
};

}  // namespace

ConeNewtonReport cone_newton(const ContactProblem& problem, const ContactScales& scales,
                             const std::vector<FrictionCone>& cones,
                             const ConeNewtonOptions& options, BodySpace& space,
                             ConeNewtonWorkspace& ws, std::vector<Vec3>& impulse,
                             std::vector<Vec3>& moment) {
  const std::size_t nc = problem.contacts.size();
  ConeNewtonReport report;
  report.residual = std::numeric_limits<double>::infinity();
  if (nc == 0) {
    report.residual = 0.0;
    return report;
  }
  ws.anchor.resize(nc);
  ws.reaction.resize(nc);
  ws.argument.resize(nc);
  ws.slip_step.resize(nc);
  ws.slip.resize(nc);
  ws.d.resize(nc);
  Newton newton{problem, cones, options, space, ws};
  const double w_min = scales.least_w;
  velocity_from_impulses(problem, impulse, moment, ws.v);
  ws.best_impulse = impulse;
  ws.best_moment = moment;
  report.residual = natural_map_residual(problem, scales, cones, impulse, moment, ws.v).natural_map;
  int without_progress = 0;
  newton.eps = options.first_softness * w_min;
  if (options.first_softness < 1.0 &&
      report.residual <=
          options.good_start) {  // a start that is nearly right allows a stiff first step
    newton.eps = std::max(options.softness, 10.0 * report.residual) * w_min;
  }
  while (report.outer < options.max_outer && report.steps < options.max_steps) {
    ++report.outer;
    velocity_from_impulses(problem, impulse, moment, ws.v);
    newton.start(impulse, moment, ws.v);
    const int steps = newton.inner();
    report.steps += std::abs(steps);
    if (steps < 0) {  // too stiff from here: a shorter proximal step from the same point
      newton.eps = std::min(newton.eps * 10.0, 100.0 * w_min);
      if (++without_progress >= 8) break;
      continue;
    }
    for (std::size_t i = 0; i < nc; ++i) {
      impulse[i] = ws.reaction[i].force;
      if (cones[i].has_moment()) moment[i] = cones[i].length * ws.reaction[i].moment;
    }
    velocity_from_impulses(problem, impulse, moment, ws.v);
    const double r =
        natural_map_residual(problem, scales, cones, impulse, moment, ws.v).natural_map;
    const bool reached = report.residual <= options.tolerance;
    const double rate = r / report.residual;
    if (r < report.residual) {
      // A term that is renewed between the steps approaches its limit slowly.
      without_progress =
          rate < (options.map == Map::kAssociated ? 0.98 : 0.5) ? 0 : without_progress + 1;
      report.residual = r;
      ws.best_impulse = impulse;
      ws.best_moment = moment;
    } else {
      ++without_progress;
    }
    // One step more than the tolerance asks for is cheap, and the forces of slender stacks need it.
    if (r <= options.plenty || (reached && rate > 0.1) || without_progress >= 8) break;
    // Crawling where only rounding is left.
    if (report.residual <= options.enough && rate > 0.3) break;
    if (rate > 0.01) {
      newton.eps =
          std::max(newton.eps * (steps <= 3 ? options.hardening : 0.2), options.softness * w_min);
    }
  }
  impulse = ws.best_impulse;
  moment = ws.best_moment;
  return report;
}

}  // namespace rb
