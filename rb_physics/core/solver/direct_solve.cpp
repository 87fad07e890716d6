// Islands whose factorisation is affordable: Newton to rounding, from one start or another.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "solver/contact_operators.hpp"
#include "solver/contact_solve.hpp"
#include "solver/friction_path.hpp"
#include "solver/interior_point.hpp"

namespace rb {

namespace {

constexpr int kRetries = 2;        // attempts from the same start, after which come others
constexpr int kStarts = 8;         // other starts, before the first one again with more sweeps
constexpr int kJamSweeps = 800;    // wide, in a jam
constexpr int kJamPatience = 160;  // sweeps
constexpr int kLargeSweeps = 320;  // wide, of many contacts that are no jam
constexpr int kLargePatience = 64;
constexpr double kJamStart = 1e-8;  // there Newton gains nothing from farther away
constexpr int kFriction = 1500;     // steps of the friction path, of which many contacts take fewer
constexpr double kNear = 1e-6;      // the friction path begins far away and ends there no nearer
constexpr double kGain = 0.1;       // of many contacts: less for another attempt is not worth it
constexpr int kRetrySweeps = 60;    // before another Newton attempt
constexpr double kGoodStart = 1e-3;  // a warm start below it goes to Newton as it is
constexpr double kCentral = 1e-5;    // where the interior-point method hands over to Newton
constexpr int kMostCentral = 30;     // its steps

}  // namespace

void ContactSolve::newton(int attempt, double softness, int most_outer) {
  ConeNewtonOptions options;
  options.max_outer = most_outer;
  options.softness = softness;
  options.tolerance = std::min(target, goal());
  options.good_start = kGoodStart;
  if (large())
    options.enough = std::max(settings.enough, jam() ? tolerance::residual_ceiling : 0.0);
  if (!settings.minimum_norm) options.plenty = settings.newton_goal;
  if (jam()) {
    options.max_steps = 12;
    options.softness = std::max(softness, 3e-6);  // stiffer steps find no way down
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
  const ConeNewtonReport r = cone_newton(problem, ws.scales, ws.cones, options, ws.space, ws.newton,
                                         io.impulse, io.moment);
  report.newton_steps += r.steps;
  work += r.steps * (ws.space.factor_work() / 100.0 + 4.0 * problem.contacts.size());
}

bool ContactSolve::pivot_normals() {
  if (out_of_work()) return false;
  FrictionlessOptions options;
  options.unique = settings.minimum_norm;
  options.max_work = settings.max_factor_work;
  options.rounding = floor * typical;
  ws.saved_impulse = io.impulse;
  ws.certificate = io.certificate;
  const FrictionlessReport r =
      solve_frictionless(problem, options, ws.v, ws.frictionless, io.impulse, ws.certificate);
  report.newton_steps += r.factorizations;
  work += r.work / 100.0 + 4.0 * r.factorizations * static_cast<double>(problem.contacts.size());
  if (!r.solved) return false;
  if (measure().natural_map <= target) {
    io.certificate.swap(ws.certificate);
    report.minimum_norm = r.unique;
    report.factorizations = r.factorizations;
    return true;
  }
  io.impulse = ws.saved_impulse;
  measure();
  return false;
}

bool ContactSolve::jam() const { return io.moment.empty() && ws.space.is_jam(); }

void ContactSolve::interior() {
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

void ContactSolve::solve_direct() {
  const bool single = problem.contacts.size() == 1 && io.moment.empty();
  if (jam() && !(report.residual <= kJamStart)) {
    wide_sweeps(kJamSweeps, kJamPatience);
    measure();
  } else if (single || !(report.residual <= kGoodStart)) {
    sweep(single ? 1 : kFirstSweeps);
    measure();
  }
  const auto reached = [&](int attempt) {  // the first one goes on to rounding
    return report.residual <= (attempt == 0 ? std::min(target, goal()) : target);
  };
  // The interior-point method knows no moments; and between nearly opposite normals, where few
  // contacts jam, the centre of the answers lies at infinity.
  if (report.residual <= kTouchUp && !reached(0)) {
    const double before = report.residual;
    newton(0, kSoftness, 2);
    measure();
    constexpr double crawls = 0.1;
    if (jam() && report.residual <= settings.enough && report.residual > crawls * before) return;
  }
  bool central = !io.moment.empty() || !large();
  double best = std::numeric_limits<double>::infinity();
  const auto keep_best = [&] {
    if (!(report.residual < best)) return;
    best = report.residual;
    ws.best_impulse = io.impulse;
    ws.best_moment = io.moment;
  };
  int attempts = settings.newton_attempts;
  if (jam()) attempts = report.residual <= kJamStart ? std::min(attempts, 1) : 0;
  for (int k = 0; k < attempts && !reached(k) && !out_of_work(); ++k) {
    const double start = report.residual;
    // What is left is the rounding of an ill-conditioned island: no use to insist.
    if (report.residual <= settings.enough && k >= (large() ? 1 : 2)) break;
    if (!central && (k > 0 || (large() && report.residual > kGoodStart))) {
      interior();
      central = true;
      if (report.residual <= target) break;
    } else if (k == kRetries + 1 && !large()) {
      if (report.residual <= kNear) {
        sweep(kRetrySweeps << kRetries);
      } else {
        follow_friction(kFriction);
      }
      keep_best();
      if (report.residual <= std::max(target, settings.enough)) break;
    } else if (k == kRetries + 2 && !large() && io.moment.empty()) {
      start_elsewhere(0);
      interior();
    } else if (k > kRetries + 1 && k <= kRetries + 1 + kStarts && !large()) {
      start_elsewhere(k - kRetries - 2);
    } else if (k > 0) {
      sweep(kRetrySweeps << (k <= kRetries || large() ? k - 1 : k - kStarts - 1));
    }
    newton(k, kSoftness, jam() ? 10 : 30);
    measure();
    keep_best();
    if (large() && k > 0 && report.residual > kGain * start) break;
  }
  const auto take_best = [&] {
    if (!(report.residual > best)) return;
    io.impulse = ws.best_impulse;
    io.moment = ws.best_moment;
    measure();
  };
  take_best();
  if (large() || report.residual <= std::max(target, settings.enough) || out_of_work()) return;
  keep_best();
  follow_friction(1);  // from there, on the map that judges
  take_best();
}

void ContactSolve::follow_friction(int most_steps) {
  // Dense: a step costs the cube of their number.
  constexpr double few = 12.0;  // contacts
  const double share = std::fmin(1.0, few / static_cast<double>(problem.contacts.size()));
  const int most = std::max(1, static_cast<int>(share * share * share * most_steps));
  const FrictionPathReport r =
      friction_path(problem, ws.scales, ws.cones, most, io.impulse, io.moment);
  const double n = (io.moment.empty() ? 3.0 : 6.0) * static_cast<double>(problem.contacts.size());
  report.newton_steps += r.steps;
  work += r.steps * n * n * n / 300.0;
  measure();
}

void ContactSolve::start_elsewhere(int number) {
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

}  // namespace rb
