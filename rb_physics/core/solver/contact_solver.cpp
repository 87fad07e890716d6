#include "solver/contact_solver.hpp"

#include <atomic>

#include "solver/contact_operators.hpp"
#include "solver/contact_solve.hpp"
#include "solver/residual.hpp"

namespace rb {

namespace {

constexpr std::size_t kMany = 400;  // contacts: of more it is first asked whether to factorise

}  // namespace

ContactResidual ContactSolve::measure() {
  velocity_from_impulses(problem, io.impulse, io.moment, ws.v);
  work += 1.0 * static_cast<double>(problem.contacts.size());
  const ContactResidual r =
      natural_map_residual(problem, ws.scales, ws.cones, io.impulse, io.moment, ws.v, &ws.slips);
  report.residual = r.natural_map;
  typical = r.typical_velocity;
  measured = r;
  floor = rounding_floor(problem, ws.v, r.typical_velocity);
  target = std::max(settings.tolerance, floor);
  return r;
}

void ContactSolve::start() {
  const std::size_t nc = problem.contacts.size();
  ws.cones.resize(nc);
  ws.kinetic.assign(nc, 0);
  std::atomic<bool> moments = false, two_coefficients = false, friction = false;
  ws.wide.share_range(nc, 256, [&](std::size_t begin, std::size_t end) {
    bool any_moment = false, any_two = false, any_friction = false;
    for (std::size_t i = begin; i < end; ++i) {
      const ContactConstraint& c = problem.contacts[i];
      ws.cones[i] = friction_cone(problem, c, Friction::kStatic);
      any_moment |= ws.cones[i].has_moment();
      any_friction |= ws.cones[i].slide > 0.0;
      any_two |= c.static_friction > c.friction;
    }
    if (any_moment) moments = true;
    if (any_friction) friction = true;
    if (any_two) two_coefficients = true;
  });
  may_release = two_coefficients;
  has_friction = friction || moments;
  if (io.impulse.size() != nc) {
    io.impulse.assign(nc, Vec3::Zero());
    io.moment.clear();
  }
  if (io.certificate.size() != problem.inv_mass.size()) {
    io.certificate.assign(problem.inv_mass.size(), Vec6::Zero());
  }
  if (!moments) {
    io.moment.clear();
  } else if (io.moment.size() != nc) {
    io.moment.assign(nc, Vec3::Zero());
  }
}

bool ContactSolve::release_sliding(double typical_velocity) {
  bool changed = false;
  for (std::size_t i = 0; may_release && i < problem.contacts.size(); ++i) {
    const ContactConstraint& c = problem.contacts[i];
    if (ws.kinetic[i] || !(c.static_friction > c.friction)) continue;
    if (relative_velocity(c, ws.v).tail<2>().norm() > kStickSlip * typical_velocity) {
      ws.kinetic[i] = 1;
      ws.cones[i].slide = c.friction;
      changed = true;
    }
  }
  return changed;
}

bool ContactSolve::accept_warm_start() {
  const ContactResidual r = measure();
  report.start_residual = r.natural_map;
  report.typical_velocity = r.typical_velocity;
  const double speed = r.natural_map * r.typical_velocity;
  const bool near = r.natural_map <= settings.warm_tolerance && speed <= settings.warm_speed;
  if (!near && !(r.natural_map <= floor)) return false;
  if (r.typical_velocity == 0.0) return report.minimum_norm = true;
  if (release_sliding(r.typical_velocity)) return false;
  if (settings.minimum_norm && problem.contacts.size() > 1 && !gave_up()) {
    cone_faces(problem, ws.cones, ws.v, ws.slips, face_threshold(r), ws.minimum_norm.faces);
    if (!is_minimum_norm(problem, ws.cones, ws.minimum_norm.faces, io.impulse, io.moment,
                         io.certificate, settings.warm_tolerance)) {
      return false;
    }
  }
  report.minimum_norm = (settings.minimum_norm && !gave_up()) || problem.contacts.size() == 1;
  return true;
}

void ContactSolve::run() {
  start();
  const bool many = problem.contacts.size() > kMany && io.moment.empty();
  if (many) {
    bool direct = false;
    ws.wide.begin_load(problem,
                       [&] { direct = ws.space.prepare(problem, settings.max_factor_work); });
    if (!direct) {
      io.vain_searches = 0;
      return iterate();
    }
    ws.wide.forget();
  }
  contact_scales(problem, ws.scales);
  if (accept_warm_start()) {
    report.warm_accepted = true;
    return;
  }
  constexpr double same = 1e-6;  // relative: the same contacts carry
  if (!(report.start_residual <= same)) io.vain_searches = 0;
  if (!has_friction && pivot_normals()) return;
  const bool direct = many || ws.space.prepare(problem, settings.max_factor_work);
  if (!direct && io.moment.empty()) return iterate();
  if (direct && !gave_up() && (touch_up() || follow_certificate())) return;
  for (;;) {
    direct ? solve_direct() : iterate_moments();
    // Near the answer, but not as near as is promised: the same attempts from there mostly end at
    // it.
    constexpr int more_rounds = 3;
    constexpr double near = 1e-4;
    for (int k = 0; direct && !large() && k < more_rounds && !out_of_work(); ++k) {
      if (report.residual <= tolerance::residual_ceiling || report.residual > near) break;
      solve_direct();
    }
    const ContactResidual r = measured;
    if (!out_of_work() && release_sliding(r.typical_velocity)) {
      measure();
      continue;
    }
    if (direct) {
      jam() ? least_impulses_of_jam(r) : least_impulses(even_slides(r));
    } else {
      io.certificate.assign(problem.inv_mass.size(), Vec6::Zero());
    }
    break;
  }
  if (report.residual > tolerance::residual_ceiling) lose_energy();
  report.factorizations = ws.space.factorizations();
}

// Sums over blocks of contacts, then over blocks: of the same bits on any number of threads.
ContactSolve::Power ContactSolve::power() {
  constexpr std::size_t block = 512;  // contacts
  const std::size_t nc = problem.contacts.size();
  const std::size_t blocks = (nc + block - 1) / block;
  ws.powers.assign(blocks, Power{});
  ws.wide.share_range(blocks, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t b = first; b < last; ++b) {
      Power& sum = ws.powers[b];
      for (std::size_t i = b * block; i < std::min(nc, (b + 1) * block); ++i) {
        const ContactConstraint& c = problem.contacts[i];
        const Vec3 before = relative_velocity(c, problem.velocity);
        sum.approach += io.impulse[i].dot(before);
        sum.turned += io.impulse[i].dot(relative_velocity(c, ws.v) - before);
        if (io.moment.empty()) continue;
        const Vec3 spin = relative_spin(c, problem.velocity);
        sum.approach += io.moment[i].dot(spin);
        sum.turned += io.moment[i].dot(relative_spin(c, ws.v) - spin);
      }
    }
  });
  Power all;
  for (const Power& p : ws.powers) {
    all.approach += p.approach;
    all.turned += p.turned;
  }
  return all;
}

// 1 if the impulses gain no energy, f . (A f + 2 u-) <= 0.
double ContactSolve::harmless_share() {
  const Power p = power();
  return p.turned + 2.0 * p.approach > 0.0 ? p.least_energy_share() : 1.0;
}

// True if the impulses gained energy: then they are what is harmless of them.
bool ContactSolve::shrink() {
  const double share = harmless_share();
  if (share == 1.0) return false;
  for (Vec3& f : io.impulse) f *= share;
  return true;
}

// What is not solved must not gain energy. Impulses in one proportion stay in their cones.
void ContactSolve::lose_energy() {
  constexpr int sweeps = 60;
  constexpr double worthless = 0.5;  // little of them is left: sweeps from nothing do better
  double share = harmless_share();
  if (share < worthless && !out_of_work()) {
    std::fill(io.impulse.begin(), io.impulse.end(), Vec3::Zero());
    std::fill(io.moment.begin(), io.moment.end(), Vec3::Zero());
    sweep(sweeps);
    measure();
    share = harmless_share();
  }
  if (share == 1.0) return;
  for (Vec3& f : io.impulse) f *= share;
  for (Vec3& m : io.moment) m *= share;
  measure();
}

SolveReport solve_contacts(const ContactProblem& problem, const SolverSettings& settings,
                           ContactSolution& io, SolverWorkspace& workspace) {
  SolveReport report;
  if (problem.contacts.empty()) {
    io.impulse.clear();
    io.moment.clear();
    io.certificate.clear();
    io.vain_searches = 0;
    io.velocity = problem.velocity;
    report.converged = report.minimum_norm = true;
  } else {
    ContactSolve solve{problem, settings, io, workspace, {}};
    solve.run();
    report = solve.report;
    report.converged = report.warm_accepted || report.residual <= solve.target;
    io.velocity = workspace.v;
  }
  io.residual = report.residual;
  io.iterations = report.sweeps + report.newton_steps;
  io.converged = report.converged;
  io.minimum_norm = report.minimum_norm;
  return report;
}

}  // namespace rb
