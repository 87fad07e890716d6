// Of all impulses that solve the problem the least, and what rounding spoils of them set right.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "solver/contact_operators.hpp"
#include "solver/contact_solve.hpp"

namespace rb {

bool ContactSolve::refine() {
  if (!settings.minimum_norm || out_of_work()) return false;
  cone_faces(problem, ws.cones, ws.v, face_threshold(measured), ws.minimum_norm.faces);
  const bool refined =
      refine_minimum_norm(problem, ws.cones, kSoftness * ws.scales.least_w, settings.tolerance,
                          ws.v, ws.space, ws.minimum_norm, io.impulse, io.certificate);
  if (refined) measure();
  report.newton_steps += refined;
  return refined;
}

bool ContactSolve::touch_up() {
  if (!(report.residual <= kTouchUp) || !refine()) return false;
  report.factorizations = ws.space.factorizations();
  report.minimum_norm = report.residual <= std::max(kRounding, std::min(target, goal()));
  if (report.minimum_norm) io.vain_searches = 0;
  return report.minimum_norm;
}

bool ContactSolve::follow_certificate() {
  constexpr int most_passes = 5;
  constexpr double few_digits = 1e-10;  // left: beyond it the answer moves by increments
  constexpr double slow = 0.1;          // of the residual left by a pass: other contacts carry
  const auto carries = [](const Vec3& f) { return !f.isZero(0.0); };
  if (!settings.minimum_norm || problem.contacts.size() < 2 || !io.moment.empty() ||
      !(report.residual <= kFollow) || std::none_of(io.impulse.begin(), io.impulse.end(), carries))
    return false;
  ws.saved_impulse = io.impulse;
  ws.certificate = io.certificate;
  MinimumNormWorkspace& least = ws.minimum_norm;
  least.faces.assign(problem.contacts.size(), {});
  for (std::size_t i = 0; i < least.faces.size(); ++i)
    least.faces[i].open = !carries(io.impulse[i]);
  const auto good = [&] { return std::max(kRounding, std::min(target, goal())); };
  const auto done = [&] {
    if (!(report.residual <= good())) return false;
    cone_faces(problem, ws.cones, ws.v, face_threshold(measured), least.faces);
    const auto slides = [](const ConeFace& f) { return f.slides && !f.open; };
    if (std::any_of(least.faces.begin(), least.faces.end(), slides)) return false;
    return is_minimum_norm(problem, ws.cones, least.faces, io.impulse, io.moment, io.certificate,
                           settings.tolerance);
  };
  double last = kFollow;
  for (int pass = 0; pass < most_passes && !out_of_work(); ++pass) {
    if (last > few_digits) {
      take_certificate(problem, ws.cones, io.certificate, least, io.impulse);
      velocity_from_impulses(problem, io.impulse, io.moment, ws.v);
    }
    if (!stop_slips(problem, ws.cones, kSoftness * ws.scales.least_w, ws.v, ws.space, least,
                    io.impulse, io.certificate))
      break;
    ++report.newton_steps;
    measure();
    if (done()) {
      report.factorizations = ws.space.factorizations();
      io.vain_searches = 0;
      return report.minimum_norm = true;
    }
    if (!(report.residual <= slow * last)) break;
    last = report.residual;
  }
  io.impulse = ws.saved_impulse;
  io.certificate = ws.certificate;
  measure();
  return false;
}

ContactResidual ContactSolve::even_slides(ContactResidual r) {
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

void ContactSolve::least_impulses(const ContactResidual& r) {
  ws.certificate = io.certificate;
  io.certificate.assign(problem.inv_mass.size(), Vec6::Zero());
  if (!settings.minimum_norm || problem.contacts.size() == 1) {
    report.minimum_norm = problem.contacts.size() == 1;
    return;
  }
  if (gave_up()) return;
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
      io.vain_searches = 0;
      polish();
      return;
    }
  }
  io.impulse = ws.saved_impulse;
  io.moment = ws.saved_moment;
  io.certificate.assign(problem.inv_mass.size(), Vec6::Zero());
  ++io.vain_searches;
  measure();
}

// While it moves, the next step has another jam, and none of its impulses.
void ContactSolve::least_impulses_of_jam(const ContactResidual& r) {
  constexpr double still = 1e-3;
  if (report.start_residual <= still) return least_impulses(r);
  io.certificate.assign(problem.inv_mass.size(), Vec6::Zero());
}

void ContactSolve::polish() {
  ws.saved_impulse = io.impulse;
  ws.certificate = io.certificate;
  const double before = report.residual;
  if (!refine() || report.residual <= std::max(4.0 * before, kRounding)) return;
  io.impulse = ws.saved_impulse;
  io.certificate = ws.certificate;
  measure();
}

}  // namespace rb
