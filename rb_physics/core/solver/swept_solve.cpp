// Sweeps: a start for the direct solve, or all there is where a factorisation costs too much.
#include "solver/contact_operators.hpp"
#include "solver/contact_solve.hpp"

namespace rb {

void ContactSolve::sweep(int count) {
  if (!swept) local_delassus(problem, ws.cones, ws.gauss_seidel);
  swept = true;
  velocity_from_impulses(problem, io.impulse, io.moment, ws.v);
  for (int k = 0; k < count && !out_of_work(); ++k) {
    gauss_seidel_sweep(problem, ws.cones, ws.gauss_seidel, io.impulse, io.moment, ws.v);
    ++report.sweeps;
    work += static_cast<double>(problem.contacts.size());
  }
}

void ContactSolve::iterate_moments() {
  const std::size_t nc = problem.contacts.size();
  measure();
  ws.direction.assign(nc, Vec3::Zero());
  double last_sq = 0.0;
  for (int k = 1; report.residual > target && k <= settings.max_sweeps && !out_of_work(); ++k) {
    ws.saved_impulse = io.impulse;
    sweep(1);
    double sq = 0.0;
    for (std::size_t i = 0; i < nc; ++i) sq += (io.impulse[i] - ws.saved_impulse[i]).squaredNorm();
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

WideResidual ContactSolve::wide_sweeps(int most, int patience) {
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
  constexpr double little = 0.5;  // they should gain at least: forces drift where nothing resists
  // Of a heap nearly at rest the residual stays, for thousands of sweeps, while such forces drift:
  // the next steps go on from there.
  constexpr double calm = 1e-5, stays = 0.9;
  double before = report.residual;
  for (int k = 1; k <= most && !out_of_work(); ++k) {
    if (report.residual <= std::max(target, settings.enough)) break;
    if (patience > 0 && k > patience && k % patience == 1) {
      if (report.residual > little * before) break;
      before = report.residual;
    }
    const bool last = k == most || k % look == 0;
    ws.wide.accelerated_sweep(last);
    ++report.sweeps;
    work += static_cast<double>(problem.contacts.size());
    if (!last) continue;
    const double last_look = report.residual;
    measure_wide();
    if (patience == 0 && report.residual <= calm && report.residual >= stays * last_look) break;
  }
  if (report.work_exhausted) measure_wide();
  ws.wide.impulses(io.impulse);
  ws.wide.velocities(ws.v);
  return r;
}

void ContactSolve::iterate() {
  constexpr double far = 1e-3;  // from the answer: only then may energy be gained that shows
  constexpr int more = 16;      // sweeps
  WideResidual r = wide_sweeps(settings.max_sweeps);
  // The forces that have braked a heap are more than it takes to hold it: sweeps that go on from
  // them would throw it up.
  if (report.residual > far && shrink()) {
    r = wide_sweeps(more);
    if (shrink()) r = wide_sweeps(0);
  }
  if (!out_of_work() && release_sliding(r.typical_velocity)) return iterate();
  io.certificate.assign(problem.inv_mass.size(), Vec6::Zero());
}

}  // namespace rb
