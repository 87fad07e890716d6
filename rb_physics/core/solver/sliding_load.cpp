#include "solver/sliding_load.hpp"

#include <algorithm>
#include <cmath>

namespace rb {

double even_sliding_load(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                         double eps, BodySpace& space, MinimumNormWorkspace& ws,
                         SlidingLoadWorkspace& own, std::vector<Vec3>& impulse,
                         std::vector<Vec3>& moment) {
  const std::size_t nc = cones.size();
  bool slips = false;
  for (std::size_t i = 0; i < nc && !slips; ++i) {
    const ConeFace& f = ws.faces[i];
    slips = !f.open && ((f.slides && cones[i].slide > 0.0) || f.spins || f.rolls);
  }
  if (!slips) return 0.0;
  // What slips is no unknown: it is taken out of the cones, and of the load.
  std::vector<ConeFace>& faces = own.faces;
  std::vector<FrictionCone>& held = own.held;
  std::vector<Vec3>& free_impulse = own.impulse;
  std::vector<Vec3>& free_moment = own.moment;
  faces = ws.faces;
  held = cones;
  free_impulse = impulse;
  free_moment = moment;
  for (std::size_t i = 0; i < nc; ++i) {
    ConeFace& face = ws.faces[i];
    if (face.open) free_impulse[i].setZero();
    if (face.open && cones[i].has_moment()) free_moment[i].setZero();
    if (face.open) continue;
    if (face.slides) {
      held[i].slide = 0.0;
      free_impulse[i].tail<2>().setZero();
    }
    if (face.spins) {
      held[i].spin = 0.0;
      free_moment[i][0] = 0.0;
    }
    if (face.rolls) {
      held[i].roll = 0.0;
      free_moment[i].tail<2>().setZero();
    }
    face.slides = face.spins = face.rolls = false;
  }
  own.certificate.clear();
  const int steps =
      minimum_norm(problem, held, eps, space, ws, free_impulse, free_moment, own.certificate);
  ws.faces = faces;
  if (steps < 0) return 0.0;
  double change = 0.0;
  double largest = 0.0;
  for (std::size_t i = 0; i < nc; ++i) {
    const ConeFace& face = faces[i];
    const double n = free_impulse[i][0];
    if (face.slides) free_impulse[i].tail<2>() = -(cones[i].slide * n) * face.slide_direction;
    if (cones[i].has_moment()) {
      const double lever = cones[i].length * n;
      if (face.spins) free_moment[i][0] = -cones[i].spin * lever * face.spin_direction;
      if (face.rolls) free_moment[i].tail<2>() = -(cones[i].roll * lever) * face.roll_direction;
    }
    largest = std::max(largest, impulse[i].norm());
    change = std::max(change, (free_impulse[i] - impulse[i]).norm());
  }
  impulse.swap(free_impulse);
  moment.swap(free_moment);
  return largest > 0.0 ? change / largest : 0.0;
}

}  // namespace rb
