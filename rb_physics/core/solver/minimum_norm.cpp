#include "solver/minimum_norm.hpp"

#include <algorithm>
#include <cmath>

#include "solver/contact_operators.hpp"

namespace rb {
namespace {

constexpr double kNear = 1e-3;      // a certificate that leaves no more of the target is a start
constexpr double kRefined = 1e-11;  // of the target: from here on the answer moves by increments

// J_i y as a reaction (no bias).
Reaction contact_components(const ContactConstraint& c, const FrictionCone& cone,
                            const std::vector<Vec6>& y) {
  Reaction r;
  r.force = relative_motion(c, y);
  if (cone.has_moment()) r.moment = cone.length * relative_turning(c, y);
  return r;
}

struct Newton {
  const ContactProblem& problem;
  const std::vector<FrictionCone>& cones;
  BodySpace& space;
  MinimumNormWorkspace& ws;

  // ws.dz := target - B^T J^T P_F(J y); returns its norm.
  double evaluate() {
    ws.wrench.assign(ws.y.size(), Vec6::Zero());
    for (std::size_t i = 0; i < cones.size(); ++i) {
      ws.argument[i] = contact_components(problem.contacts[i], cones[i], ws.y);
      ws.reaction[i] = project_on_face(cones[i], ws.faces[i], ws.argument[i], &ws.d[i]);
      add_wrench(problem.contacts[i], cones[i], ws.reaction[i], ws.wrench);
    }
    return missing();
  }

  // ws.dz := target - B^T ws.wrench; returns its norm.
  double missing() {
    space.scale_transposed(ws.wrench, ws.dz);
    double sq = 0.0;
    for (std::size_t i = 0; i < ws.dz.size(); ++i) {
      ws.dz[i] = ws.target[i] - ws.dz[i];
      sq += ws.dz[i].squaredNorm();
    }
    return std::sqrt(sq);
  }

  // A Newton step that adds to the reactions. Up a stack y grows with the square of its height, and
  // differences of it are no better than its rounding: what is missing is.
  double refine() {
    space.scale(ws.dz, ws.y_step);
    ws.wrench.assign(ws.y.size(), Vec6::Zero());
    for (std::size_t i = 0; i < cones.size(); ++i) {
      const Reaction step = contact_components(problem.contacts[i], cones[i], ws.y_step);
      const ReactionDerivative& d = ws.d[i];
      Reaction& r = ws.reaction[i];
      r.force += d.ff * step.force + d.fm * step.moment;
      r.moment += d.mf * step.force + d.mm * step.moment;
      r = project_on_face(cones[i], ws.faces[i], r, nullptr);
      add_wrench(problem.contacts[i], cones[i], r, ws.wrench);
    }
    for (std::size_t i = 0; i < ws.y.size(); ++i) ws.y[i] += ws.y_step[i];
    return missing();
  }

  // Slope of the dual energy sum |P_F|^2 / 2 - target . z along dz.
  double slope(double step, double target_step) {
    double s = -target_step;
    for (std::size_t i = 0; i < cones.size(); ++i) {
      const Reaction a{ws.argument[i].force + step * ws.argument_step[i].force,
                       ws.argument[i].moment + step * ws.argument_step[i].moment};
      const Reaction g = project_on_face(cones[i], ws.faces[i], a, nullptr);
      s += g.force.dot(ws.argument_step[i].force) + g.moment.dot(ws.argument_step[i].moment);
    }
    return s;
  }

  // y = 0. There every P_F is at its apex, where the Jacobian says nothing: that inside K instead.
  void start() {
    ws.y.assign(problem.inv_mass.size(), Vec6::Zero());
    for (std::size_t i = 0; i < cones.size(); ++i) {
      const ConeFace& face = ws.faces[i];
      ws.argument[i] = {};
      ws.d[i].ff.setZero();
      ws.d[i].fm.setZero();
      ws.d[i].mf.setZero();
      ws.d[i].mm.setZero();
      if (face.open) continue;
      ws.d[i].ff.setIdentity();
      ws.d[i].mm.setIdentity();
      if (face.slides || cones[i].slide == 0.0) {
        const double mu = cones[i].slide;
        const Vec3 ray(1.0, -mu * face.slide_direction[0], -mu * face.slide_direction[1]);
        ws.d[i].ff = ray * ray.transpose() / (1.0 + mu * mu);
      }
    }
    ws.dz = ws.target;
  }

  double step() {
    const double length = line_search();
    for (std::size_t i = 0; i < ws.y.size(); ++i) ws.y[i] += length * ws.y_step[i];
    return evaluate();
  }

  double line_search() {
    double target_step = 0.0;
    for (std::size_t i = 0; i < ws.dz.size(); ++i) target_step += ws.target[i].dot(ws.dz[i]);
    space.scale(ws.dz, ws.y_step);
    for (std::size_t i = 0; i < cones.size(); ++i) {
      ws.argument_step[i] = contact_components(problem.contacts[i], cones[i], ws.y_step);
    }
    const double at_zero = slope(0.0, target_step);
    double high = 1.0;
    double f_high = slope(high, target_step);
    if (f_high <= 0.1 * std::abs(at_zero)) return 1.0;
    double low = 0.0;
    double f_low = at_zero;
    double step = 1.0;
    for (int k = 0; k < 12; ++k) {
      step = (low * f_high - high * f_low) / (f_high - f_low);
      const double margin = 0.1 * (high - low);
      step = std::clamp(step, low + margin, high - margin);
      const double f = slope(step, target_step);
      if (std::abs(f) <= 0.1 * std::abs(at_zero)) break;
      (f < 0.0 ? low : high) = step;
      (f < 0.0 ? f_low : f_high) = f;
    }
    return step;
  }
};

}  // namespace

namespace {

ConeFace face_of(const ContactConstraint& c, const FrictionCone& cone, const Vec3& u,
                 const std::vector<Vec6>& v, double threshold) {
  ConeFace face;
  if (u[0] > threshold) {
    face.open = true;
    return face;
  }
  const double slide = u.tail<2>().norm();
  if (slide > threshold) {
    face.slides = true;
    face.slide_direction = u.tail<2>() / slide;
  }
  if (!cone.has_moment()) return face;
  const Vec3 w = cone.length * relative_spin(c, v);
  const double roll = w.tail<2>().norm();
  if (std::abs(w[0]) > threshold) {
    face.spins = true;
    face.spin_direction = w[0] > 0.0 ? 1.0 : -1.0;
  }
  if (roll > threshold) {
    face.rolls = true;
    face.roll_direction = w.tail<2>() / roll;
  }
  return face;
}

}  // namespace

void cone_faces(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                const std::vector<Vec6>& v, double threshold, std::vector<ConeFace>& faces) {
  faces.resize(cones.size());
  for (std::size_t i = 0; i < cones.size(); ++i) {
    const ContactConstraint& c = problem.contacts[i];
    faces[i] = face_of(c, cones[i], relative_velocity(c, v), v, threshold);
  }
}

void cone_faces(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                const std::vector<Vec6>& v, const std::vector<Vec3>& slips, double threshold,
                std::vector<ConeFace>& faces) {
  faces.resize(cones.size());
  for (std::size_t i = 0; i < cones.size(); ++i)
    faces[i] = face_of(problem.contacts[i], cones[i], slips[i], v, threshold);
}

bool is_minimum_norm(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                     const std::vector<ConeFace>& faces, const std::vector<Vec3>& impulse,
                     const std::vector<Vec3>& moment, const std::vector<Vec6>& certificate,
                     double tolerance) {
  if (certificate.size() != problem.inv_mass.size()) return false;
  double largest = 0.0;
  double deviation = 0.0;
  for (std::size_t i = 0; i < cones.size(); ++i) {
    largest = std::max(largest, impulse[i].squaredNorm());
    if (!cones[i].has_moment() && !faces[i].open && !faces[i].slides) {
      const Vec3 y = relative_motion(problem.contacts[i], certificate);
      const Vec3 force = project_on_plain_cone(cones[i].slide, y, nullptr);
      const double sq = (force - impulse[i]).squaredNorm();
      if (!(sq <= deviation)) deviation = sq;
      continue;
    }
    const Reaction r =
        project_on_face(cones[i], faces[i],
                        contact_components(problem.contacts[i], cones[i], certificate), nullptr);
    double sq = (r.force - impulse[i]).squaredNorm();
    if (cones[i].has_moment()) sq += (r.moment - moment[i] / cones[i].length).squaredNorm();
    if (!(sq <= deviation)) deviation = sq;
  }
  return deviation <= tolerance * tolerance * largest;
}

int minimum_norm(const ContactProblem& problem, const std::vector<FrictionCone>& cones, double eps,
                 BodySpace& space, MinimumNormWorkspace& ws, std::vector<Vec3>& impulse,
                 std::vector<Vec3>& moment, std::vector<Vec6>& certificate) {
  const std::size_t nc = cones.size();
  const std::size_t nb = problem.inv_mass.size();
  ws.argument.resize(nc);
  ws.argument_step.resize(nc);
  ws.reaction.resize(nc);
  ws.d.resize(nc);
  ws.wrench.assign(nb, Vec6::Zero());
  for (std::size_t i = 0; i < nc; ++i) {
    Reaction r{impulse[i], Vec3::Zero()};
    if (cones[i].has_moment()) r.moment = moment[i] / cones[i].length;
    add_wrench(problem.contacts[i], cones[i], r, ws.wrench);
  }
  space.scale_transposed(ws.wrench, ws.target);
  double scale = 0.0;
  for (const Vec6& t : ws.target) scale += t.squaredNorm();
  scale = std::sqrt(scale);
  Newton newton{problem, cones, space, ws};
  double norm = scale;
  if (certificate.size() == nb) {
    ws.y = certificate;
    norm = newton.evaluate();
  }
  // Without a certificate also where there is no load at all and nothing is left of it.
  if (certificate.size() != nb || !(norm <= kNear * scale)) {
    norm = scale;
    newton.start();
  }
  int steps = 0;
  constexpr int kMaxSteps = 12;  // it converges in 2 to 8 or not at all
  // Some contact's force would have to lie on its cone's edge, and y at infinity.
  constexpr int kFewSteps = 2;
  constexpr double kHopeless = 0.8;
  while (steps < kMaxSteps) {
    if (!space.factorize(problem, cones, ws.d, 1.0 / eps, true)) return -steps - 1;
    for (Vec6& x : ws.dz) x /= eps;
    space.solve(ws.dz);
    const double last = norm;
    norm = last <= kRefined * scale ? newton.refine() : newton.step();
    ++steps;
    if (steps == kFewSteps && norm > kHopeless * scale) break;
    if (norm <= 4e-16 * scale || (norm > 0.3 * last && last <= 1e-13 * scale)) break;
  }
  if (!(norm <= 1e-12 * scale)) return -steps - 1;
  for (std::size_t i = 0; i < nc; ++i) {
    impulse[i] = ws.reaction[i].force;
    if (cones[i].has_moment()) moment[i] = cones[i].length * ws.reaction[i].moment;
  }
  certificate = ws.y;
  return steps;
}

bool refine_minimum_norm(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                         double eps, double tolerance, const std::vector<Vec6>& v, BodySpace& space,
                         MinimumNormWorkspace& ws, std::vector<Vec3>& impulse,
                         std::vector<Vec6>& certificate) {
  const std::size_t nc = cones.size();
  if (certificate.size() != problem.inv_mass.size()) return false;
  ws.reaction.resize(nc);
  ws.d.resize(nc);
  double largest = 0.0;
  double deviation = 0.0;
  for (std::size_t i = 0; i < nc; ++i) {
    const ContactConstraint& c = problem.contacts[i];
    if (cones[i].has_moment() || (ws.faces[i].slides && cones[i].slide > 0.0)) return false;
    const Reaction y = contact_components(c, cones[i], certificate);
    const Reaction r = project_on_face(cones[i], ws.faces[i], y, &ws.d[i]);
    largest = std::max(largest, impulse[i].squaredNorm());
    const double sq = (r.force - impulse[i]).squaredNorm();
    if (!(sq <= deviation)) deviation = sq;
    ws.reaction[i] = {impulse[i], Vec3::Zero()};
  }
  if (!(deviation <= tolerance * tolerance * largest)) return false;
  return stop_slips(problem, cones, eps, v, space, ws, impulse, certificate);
}

void take_certificate(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                      const std::vector<Vec6>& certificate, MinimumNormWorkspace& ws,
                      std::vector<Vec3>& impulse) {
  const std::size_t nc = cones.size();
  ws.reaction.resize(nc);
  ws.d.resize(nc);
  for (std::size_t i = 0; i < nc; ++i) {
    const Reaction y = contact_components(problem.contacts[i], cones[i], certificate);
    ws.reaction[i] = project_on_face(cones[i], ws.faces[i], y, &ws.d[i]);
    impulse[i] = ws.reaction[i].force;
  }
}

bool stop_slips(const ContactProblem& problem, const std::vector<FrictionCone>& cones, double eps,
                const std::vector<Vec6>& v, BodySpace& space, MinimumNormWorkspace& ws,
                std::vector<Vec3>& impulse, std::vector<Vec6>& certificate) {
  const std::size_t nb = problem.inv_mass.size();
  ws.wrench.assign(nb, Vec6::Zero());
  for (std::size_t i = 0; i < cones.size(); ++i) {
    const Vec3 slip = relative_velocity(problem.contacts[i], v);
    add_wrench(problem.contacts[i], cones[i], {ws.d[i].ff * -slip / eps, Vec3::Zero()}, ws.wrench);
  }
  if (!space.factorize(problem, cones, ws.d, 1.0 / eps, true)) return false;
  // The change of velocity that stops them, as B dz; then the reactions that make it.
  space.scale_transposed(ws.wrench, ws.dz);
  space.solve(ws.dz);
  for (Vec6& x : ws.dz) x /= eps;
  space.solve(ws.dz);
  ws.y = certificate;
  ws.target.assign(nb, Vec6::Zero());
  Newton{problem, cones, space, ws}.refine();
  for (std::size_t i = 0; i < cones.size(); ++i) impulse[i] = ws.reaction[i].force;
  certificate = ws.y;
  return true;
}

}  // namespace rb
