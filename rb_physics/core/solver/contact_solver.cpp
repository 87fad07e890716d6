#include "solver/contact_solver.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <limits>

#include "solver/contact_operators.hpp"
#include "solver/interior_point.hpp"
#include "solver/residual.hpp"

namespace rb {
namespace {

constexpr std::size_t kMany = 400;   // contacts: of more it is first asked whether to factorise
constexpr int kFirstSweeps = 5;      // find most of the active set
constexpr int kRetries = 2;          // attempts from the same start, after which come others
constexpr int kStarts = 8;           // other starts, before the first one again with more sweeps
constexpr int kJamSweeps = 400;      // the same, wide, in a jam; later four times as many
constexpr double kTowerWork = 150;   // multiply-adds of a factorisation per contact: more is a jam
constexpr int kRetrySweeps = 60;     // before another Newton attempt
constexpr double kGoodStart = 1e-3;  // a warm start below it goes to Newton as it is
constexpr std::size_t kLarge = 64;   // contacts: more of them end where rounding begins to show
constexpr double kCentral = 1e-5;    // where the interior-point method hands over to Newton
constexpr int kMostCentral = 30;     // its steps
constexpr double kSoftness = 1e-8;
constexpr double kRounding = 1e-15;  // no use to insist below it
constexpr double kTouchUp = 1e-9;    // a start below it is mostly one Newton step away

struct Solve {
  const ContactProblem& problem;
  const SolverSettings& settings;
  ContactSolution& io;
  SolverWorkspace& ws;
  SolveReport report;
  double work = 0.0;   // sweeps over one contact
  double floor = 0.0;  // what rounding leaves of the residual
  double target = 0.0;
  double typical = 0.0;           // m/s, what the residual is relative to
  ContactResidual measured = {};  // by measure(), the last time
  bool swept = false;             // what sweeps need is there
  bool may_release = true;        // some contact has two coefficients of friction

  bool out_of_work() {
    if (settings.max_work > 0 && work >= static_cast<double>(settings.max_work)) {
      report.work_exhausted = true;
    }
    return report.work_exhausted;
  }

  ContactResidual measure() {
    velocity_from_impulses(problem, io.impulse, io.moment, ws.v);
    work += 1.0 * static_cast<double>(problem.contacts.size());
    const ContactResidual r =
        natural_map_residual(problem, ws.scales, ws.cones, io.impulse, io.moment, ws.v);
    report.residual = r.natural_map;
    typical = r.typical_velocity;
    measured = r;
    floor = rounding_floor(problem, ws.v, r.typical_velocity);
    target = std::max(settings.tolerance, floor);
    return r;
  }

  // What the first Newton attempt goes on to: where light contacts are right beside heavy ones.
  double goal() const {
    constexpr double rounding = 5e-16;
    constexpr double share = 0.1;  // of what a warm start may leave
    const double light = share * settings.warm_speed / typical;
    return std::max({floor, rounding, std::min(settings.newton_goal, light)});
  }

  void start() {
    const std::size_t nc = problem.contacts.size();
    ws.cones.resize(nc);
    ws.kinetic.assign(nc, 0);
    std::atomic<bool> moments = false, two_coefficients = false;
    ws.wide.share_range(nc, 256, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const ContactConstraint& c = problem.contacts[i];
        ws.cones[i] = friction_cone(problem, c, Friction::kStatic);
        if (ws.cones[i].has_moment()) moments = true;
        if (c.static_friction > c.friction) two_coefficients = true;
      }
    });
    may_release = two_coefficients;
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

  // Slips against a static coefficient: the kinetic one from now on. True if any changed.
  bool release_sliding(double typical_velocity) {
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

  bool accept_warm_start() {
    const ContactResidual r = measure();
    report.start_residual = r.natural_map;
    report.typical_velocity = r.typical_velocity;
    const double speed = r.natural_map * r.typical_velocity;
    const bool near = r.natural_map <= settings.warm_tolerance && speed <= settings.warm_speed;
    if (!near && !(r.natural_map <= floor)) return false;
    if (r.typical_velocity == 0.0) return report.minimum_norm = true;
    if (release_sliding(r.typical_velocity)) return false;
    if (settings.minimum_norm && problem.contacts.size() > 1) {
      cone_faces(problem, ws.cones, ws.v, face_threshold(r), ws.minimum_norm.faces);
      if (!is_minimum_norm(problem, ws.cones, ws.minimum_norm.faces, io.impulse, io.moment,
                           io.certificate, settings.warm_tolerance)) {
        return false;
      }
    }
    report.minimum_norm = settings.minimum_norm || problem.contacts.size() == 1;
    return true;
  }

  // Two linear solves that take out what rounding has left or made. False: nothing changed.
  bool refine() {
    if (!settings.minimum_norm || out_of_work()) return false;
    cone_faces(problem, ws.cones, ws.v, face_threshold(measured), ws.minimum_norm.faces);
    const bool refined =
        refine_minimum_norm(problem, ws.cones, kSoftness * ws.scales.least_w, settings.tolerance,
                            ws.v, ws.space, ws.minimum_norm, io.impulse, io.certificate);
    if (refined) measure();
    report.newton_steps += refined;
    return refined;
  }

  // Most of the solves of a stack at rest: the old forces but for their drift.
  bool touch_up() {
    if (!(report.residual <= kTouchUp) || !refine()) return false;
    report.factorizations = ws.space.factorizations();
    return report.minimum_norm = report.residual <= std::max(kRounding, std::min(target, goal()));
  }

  static double face_threshold(const ContactResidual& r) {
    return std::max(1e-11, 30.0 * r.natural_map) * r.typical_velocity;
  }

  // Sweeps until the target, `count`, or the end of work.
  void sweep(int count) {
    if (!swept) local_delassus(problem, ws.cones, ws.gauss_seidel);
    swept = true;
    velocity_from_impulses(problem, io.impulse, io.moment, ws.v);
    for (int k = 0; k < count && !out_of_work(); ++k) {
      gauss_seidel_sweep(problem, ws.cones, ws.gauss_seidel, io.impulse, io.moment, ws.v);
      ++report.sweeps;
      work += static_cast<double>(problem.contacts.size());
    }
  }

  void newton(int attempt, double softness = kSoftness, int most_outer = 30) {
    ConeNewtonOptions options;
    options.max_outer = most_outer;
    options.softness = softness;
    options.tolerance = std::min(target, goal());
    if (large()) {
      options.enough = settings.enough;
      options.good_start = 1e-3;
    }
    if (attempt > 0) {
      // Softer paths to the same answer, every other one over the associated problem, whose Newton
      // steps always descend: it crawls where much slides fast, and is sure where slips are small.
      constexpr double starts[] = {10.0, 0.1, 0.1, 10.0, 1.0, 1.0, 10.0, 0.1, 10.0, 10.0};
      options.first_softness = starts[(attempt - 1) % std::size(starts)];
      options.max_inner = 25;
      if (attempt % 2 == 0 && attempt <= kRetries + kStarts) {
        options.map = ConeNewtonOptions::Map::kAssociated;
        options.max_outer = 100;
        options.max_steps = 300;
      }
    }
    const ConeNewtonReport r = cone_newton(problem, ws.scales, ws.cones, options, ws.space,
                                           ws.newton, io.impulse, io.moment);
    report.newton_steps += r.steps;
    work += r.steps * (ws.space.factor_work() / 100.0 + 4.0 * problem.contacts.size());
  }

  bool large() const { return problem.contacts.size() > kLarge; }
  // Of many contacts, and every body among many others: Newton is dear there and often circles,
  // and the next step will have another jam.
  bool jam() const {
    return large() && io.moment.empty() &&
           ws.space.factor_work() > kTowerWork * static_cast<double>(problem.contacts.size());
  }

  // A start for Newton where sweeps leave too much open. Kept if it is nearer.
  void interior() {
    ws.saved_impulse = io.impulse;
    const double before = report.residual;
    const InteriorPointReport r =
        interior_point(problem, ws.scales, ws.cones, std::max(kCentral, settings.enough),
                       kMostCentral, ws.space, ws.interior_point, io.impulse);
    report.newton_steps += r.steps;
    work += r.steps * (ws.space.factor_work() / 100.0 + 4.0 * problem.contacts.size());
    if (measure().natural_map < before) return;
    io.impulse = ws.saved_impulse;
    measure();
  }

  void solve_direct() {
    if (!(report.residual <= kGoodStart)) {
      if (jam()) {
        wide_sweeps(kJamSweeps);
      } else {
        sweep(kFirstSweeps);
      }
      measure();
    }
    const auto reached = [&](int attempt) {  // the first one goes on to rounding
      return report.residual <= (attempt == 0 ? std::min(target, goal()) : target);
    };
    // The interior-point method knows no moments; and between nearly opposite normals, where few
    // contacts jam, the centre of the answers lies at infinity.
    if (report.residual <= kTouchUp && !reached(0)) {
      newton(0, kSoftness, 2);
      measure();
    }
    bool central = !io.moment.empty() || !large();
    double best = std::numeric_limits<double>::infinity();
    const int attempts = jam() ? std::min(settings.newton_attempts, 2) : settings.newton_attempts;
    for (int k = 0; k < attempts && !reached(k) && !out_of_work(); ++k) {
      // What is left is the rounding of an ill-conditioned island: no use to insist.
      if (report.residual <= settings.enough && k >= (large() ? 1 : 2)) break;
      if (k > 0 && jam()) {
        wide_sweeps(4 * kJamSweeps);
        measure();
        if (report.residual <= settings.enough) break;
      } else if (!central && (k > 0 || (large() && report.residual > kGoodStart))) {
        interior();
        central = true;
        if (report.residual <= target) break;
      } else if (k > kRetries && k <= kRetries + kStarts && !large()) {
        start_elsewhere(k - kRetries - 1);
      } else if (k > 0) {
        sweep(kRetrySweeps << (k <= kRetries || large() ? k - 1 : k - kStarts - 1));
      }
      newton(k, kSoftness, jam() ? 10 : 30);
      measure();
      if (report.residual < best) {
        best = report.residual;
        ws.best_impulse = io.impulse;
        ws.best_moment = io.moment;
      }
    }
    if (report.residual > best) {
      io.impulse = ws.best_impulse;
      io.moment = ws.best_moment;
      measure();
    }
  }

  // Where friction is strong, Newton may circle around a start that is near: another one, from what
  // each contact asks for by itself, so that neither the order of the contacts nor the axes matter.
  void start_elsewhere(int number) {
    constexpr double share[] = {0.0, 1.0, 0.1, 10.0};  // of what stops the contact's approach
    const bool slides = number % 2 == 0;               // against friction, or free of it
    for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
      const ContactConstraint& c = problem.contacts[i];
      const Vec3 u = relative_velocity(c, problem.velocity);
      const double normal = share[number / 2 % 4] * typical / ws.scales.w[i];
      io.impulse[i] = Vec3(normal, 0.0, 0.0);
      const double slip = u.tail<2>().norm();
      if (slides && slip > 0.0) {
        io.impulse[i].tail<2>() = (-ws.cones[i].slide * normal / slip) * u.tail<2>();
      }
      if (!io.moment.empty()) io.moment[i].setZero();
    }
    if (number == 0) sweep(kFirstSweeps);
    measure();
  }

  // The same, contact by contact, for those with rolling or spinning friction.
  void iterate_moments() {
    const std::size_t nc = problem.contacts.size();
    measure();
    ws.direction.assign(nc, Vec3::Zero());
    double last_sq = 0.0;
    for (int k = 1; report.residual > target && k <= settings.max_sweeps && !out_of_work(); ++k) {
      ws.saved_impulse = io.impulse;
      sweep(1);
      double sq = 0.0;
      for (std::size_t i = 0; i < nc; ++i)
        sq += (io.impulse[i] - ws.saved_impulse[i]).squaredNorm();
      const double beta = last_sq > 0.0 ? sq / last_sq : 0.0;
      const bool last = k == settings.max_sweeps || k % 10 == 0;
      if (beta >= 1.0 || last) {  // uphill, or about to look: a plain sweep, and start again
        ws.direction.assign(nc, Vec3::Zero());
        last_sq = beta >= 1.0 ? 0.0 : sq;
      } else {
        for (std::size_t i = 0; i < nc; ++i) {
          const Vec3 change = io.impulse[i] - ws.saved_impulse[i];
          io.impulse[i] += beta * ws.direction[i];
          ws.direction[i] = beta * ws.direction[i] + change;
        }
        last_sq = sq;
      }
      if (last) measure();
    }
    measure();
  }

  // Wide sweeps, accelerated by the nonsmooth nonlinear conjugate gradient method (Silcowitz, Niebe
  // & Erleben 2010), which takes the change of one sweep for the gradient.
  WideResidual wide_sweeps(int most) {
    constexpr int look = 16;  // sweeps between two measurements
    WideResidual r;
    const auto measure_wide = [&] {
      r = ws.wide.measure();
      work += static_cast<double>(problem.contacts.size());
      report.residual = r.natural_map;
      floor = r.floor;
      target = std::max(settings.tolerance, floor);
    };
    ws.wide.load(problem, ws.cones);
    ws.wide.set_impulses(io.impulse);
    measure_wide();
    if (report.typical_velocity == 0.0) {  // nobody has looked yet
      report.start_residual = report.residual;
      report.typical_velocity = r.typical_velocity;
    }
    for (int k = 1; k <= most && !out_of_work(); ++k) {
      if (report.residual <= std::max(target, settings.enough)) break;
      const bool last = k == most || k % look == 0;
      ws.wide.accelerated_sweep(last);
      ++report.sweeps;
      work += static_cast<double>(problem.contacts.size());
      if (last) measure_wide();
    }
    if (report.work_exhausted) measure_wide();
    ws.wide.impulses(io.impulse);
    ws.wide.velocities(ws.v);
    return r;
  }

  // Large islands, where the forces take no part in a factorisation.
  void iterate() {
    const WideResidual r = wide_sweeps(settings.max_sweeps);
    if (!out_of_work() && release_sliding(r.typical_velocity)) return iterate();
    io.certificate.assign(problem.inv_mass.size(), Vec6::Zero());
  }

  // Where contacts slide: of all answers the one that their order has no part in.
  ContactResidual even_slides(ContactResidual r) {
    constexpr int most_passes = 3;
    constexpr double even = 1e-12;  // relative change of an impulse that is left alone
    // Rounding of u, divided by it, is what the steps put into the uneven part of the load.
    constexpr double softness = 1e-4;
    for (int pass = 0; pass < most_passes && problem.contacts.size() > 1; ++pass) {
      if (!settings.minimum_norm || r.natural_map > 1e-9 || out_of_work()) break;
      cone_faces(problem, ws.cones, ws.v, face_threshold(r), ws.minimum_norm.faces);
      ws.saved_impulse = io.impulse;
      ws.saved_moment = io.moment;
      const double change =
          even_sliding_load(problem, ws.cones, kSoftness * ws.scales.least_w, ws.space,
                            ws.minimum_norm, ws.sliding_load, io.impulse, io.moment);
      if (!(change > even)) {
        io.impulse = ws.saved_impulse;
        io.moment = ws.saved_moment;
        break;
      }
      newton(0, softness);
      const double before = r.natural_map;
      r = measure();
      if (r.natural_map <= std::max(4.0 * before, target)) continue;
      io.impulse = ws.saved_impulse;
      io.moment = ws.saved_moment;
      return measure();
    }
    return r;
  }

  void least_impulses(const ContactResidual& r) {
    ws.certificate = io.certificate;
    io.certificate.assign(problem.inv_mass.size(), Vec6::Zero());
    if (!settings.minimum_norm || problem.contacts.size() == 1) {
      report.minimum_norm = problem.contacts.size() == 1;
      return;
    }
    // Faces are told apart by the slips: only where those are right beyond doubt.
    if (r.natural_map > (large() ? 1e-11 : 1e-9) || out_of_work()) return;
    cone_faces(problem, ws.cones, ws.v, face_threshold(r), ws.minimum_norm.faces);
    ws.saved_impulse = io.impulse;
    ws.saved_moment = io.moment;
    const int steps = minimum_norm(problem, ws.cones, kSoftness * ws.scales.least_w, ws.space,
                                   ws.minimum_norm, io.impulse, io.moment, ws.certificate);
    report.newton_steps += std::abs(steps);
    if (steps > 0) {
      io.certificate = ws.certificate;
      const double before = r.natural_map;
      if (measure().natural_map <= std::max(4.0 * before, target)) {
        report.minimum_norm = true;
        polish();
        return;
      }
    }
    io.impulse = ws.saved_impulse;
    io.moment = ws.saved_moment;
    io.certificate.assign(problem.inv_mass.size(), Vec6::Zero());
    measure();
  }

  // What a full solve leaves sways a tower as a whole: small slips, large forces later on.
  void polish() {
    ws.saved_impulse = io.impulse;
    ws.certificate = io.certificate;
    const double before = report.residual;
    if (!refine() || report.residual <= std::max(4.0 * before, kRounding)) return;
    io.impulse = ws.saved_impulse;
    io.certificate = ws.certificate;
    measure();
  }

  void run() {
    start();
    const bool many = problem.contacts.size() > kMany && io.moment.empty();
    if (many) {
      bool direct = false;
      ws.wide.begin_load(problem,
                         [&] { direct = ws.space.prepare(problem, settings.max_factor_work); });
      if (!direct) return iterate();
      ws.wide.forget();
    }
    contact_scales(problem, ws.scales);
    if (accept_warm_start()) {
      report.warm_accepted = true;
      return;
    }
    const bool direct = many || ws.space.prepare(problem, settings.max_factor_work);
    if (!direct && io.moment.empty()) return iterate();
    if (direct && touch_up()) return;
    for (;;) {
      direct ? solve_direct() : iterate_moments();
      const ContactResidual r = measured;
      if (!out_of_work() && release_sliding(r.typical_velocity)) {
        measure();
        continue;
      }
      if (direct) {
        least_impulses(even_slides(r));
      } else {
        io.certificate.assign(problem.inv_mass.size(), Vec6::Zero());
      }
      break;
    }
    report.factorizations = ws.space.factorizations();
  }
};

}  // namespace

SolveReport solve_contacts(const ContactProblem& problem, const SolverSettings& settings,
                           ContactSolution& io, SolverWorkspace& workspace) {
  SolveReport report;
  if (problem.contacts.empty()) {
    io.impulse.clear();
    io.moment.clear();
    io.certificate.clear();
    io.velocity = problem.velocity;
    report.converged = report.minimum_norm = true;
  } else {
    Solve solve{problem, settings, io, workspace, {}};
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
