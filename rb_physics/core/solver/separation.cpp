#include "solver/separation.hpp"

namespace rb {

SeparationReport separate_bodies(const ContactProblem& problem, double slack, int most_sweeps,
                                 WideContacts& wide, std::vector<Vec6>& displacement) {
  constexpr int look = 8;  // sweeps between two measurements
  SeparationReport report;
  wide.loaded() ? wide.reload_frictionless(problem) : wide.load_frictionless(problem);
  wide.clear_impulses();
  do {
    for (int k = 1; k <= look; ++k) wide.accelerated_sweep(k == look);
    report.sweeps += look;
    report.left = wide.measure().absolute;
  } while (report.left > slack && report.sweeps < most_sweeps);
  wide.forget();
  wide.velocities(displacement);
  return report;
}

}  // namespace rb
