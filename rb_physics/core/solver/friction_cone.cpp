#include "solver/friction_cone.hpp"

#include <algorithm>
#include <cmath>

namespace rb {
namespace {

// One friction component of the cone: |x| <= mu lambda_n, x of dimension 1 or 2 (1 has x[1] = 0).
struct Component {
  double mu = 0.0;
  Vec2 a = Vec2::Zero();
  Vec2 direction = Vec2::Zero();  // of the bound the reaction sits at, unit
  double size = 0.0;              // a . direction
  bool at_bound = false;
};

// Bound side of a component that slips: opposite to the slip, whatever a is.
void slip_against(Component& c, const Vec2& slip_direction) {
  c.direction = -slip_direction;
  c.size = c.a.dot(c.direction);
  c.at_bound = true;
}

void measure(Component& c) {
  c.size = c.a.norm();
  if (c.size > 0.0) c.direction = c.a / c.size;
}

constexpr int kOffset[3] = {1, 3, 4};  // first row of slide, spin, roll in (force; moment)
constexpr int kSize[3] = {2, 1, 2};

void split(const Eigen::Matrix<double, 6, 6>& m, ReactionDerivative* d) {
  d->ff = m.topLeftCorner<3, 3>();
  d->fm = m.topRightCorner<3, 3>();
  d->mf = m.bottomLeftCorner<3, 3>();
  d->mm = m.bottomRightCorner<3, 3>();
}

void set_zero(ReactionDerivative* d) {
  if (d == nullptr) return;
  d->ff.setZero();
  d->fm.setZero();
  d->mf.setZero();
  d->mm.setZero();
}

void load(const FrictionCone& cone, const Reaction& a, Component (&c)[3]) {
  c[0].mu = cone.slide;
  c[0].a = a.force.tail<2>();
  c[1].mu = cone.spin;
  c[1].a = Vec2(a.moment[0], 0.0);
  c[2].mu = cone.roll;
  c[2].a = a.moment.tail<2>();
}

Reaction gather(double n, const Component (&c)[3], int count) {
  Reaction r;
  r.force[0] = n;
  Vec2 x[3];
  for (int k = 0; k < count; ++k) {
    x[k] = c[k].at_bound ? Vec2(c[k].mu * n * c[k].direction) : c[k].a;
  }
  r.force.tail<2>() = x[0];
  if (count == 3) {
    r.moment[0] = x[1][0];
    r.moment.tail<2>() = x[2];
  }
  return r;
}

// lambda_n of the projection, given components already pinned at a bound: minimises
// (n - a_n)^2 + sum of squared excesses; convex and piecewise quadratic, solved by adding the
// components in the order in which their bound is passed.
double normal_of_projection(double a_n, Component (&c)[3], int count) {
  double numerator = a_n;
  double denominator = 1.0;
  const auto add = [&](const Component& k) {
    numerator += k.mu * k.size;
    denominator += k.mu * k.mu;
  };
  for (int k = 0; k < count; ++k) {
    if (c[k].at_bound) add(c[k]);
  }
  for (;;) {
    const double n = numerator / denominator;
    int next = -1;
    for (int k = 0; k < count; ++k) {  // largest breakpoint |a|/mu above n first
      if (c[k].at_bound || c[k].size <= c[k].mu * n) continue;
      if (next < 0 || c[k].size * c[next].mu > c[next].size * c[k].mu) next = k;
    }
    if (next < 0) return n;
    c[next].at_bound = true;
    add(c[next]);
  }
}

void projection_derivative(double n, const Component (&c)[3], const bool (&pinned)[3], int count,
                           ReactionDerivative* d) {
  Eigen::Matrix<double, 6, 6> m = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();  // gradient of n
  double denominator = 1.0;
  g[0] = 1.0;
  for (int k = 0; k < count; ++k) {
    if (!c[k].at_bound) {
      for (int i = 0; i < kSize[k]; ++i) m(kOffset[k] + i, kOffset[k] + i) = 1.0;
      continue;
    }
    denominator += c[k].mu * c[k].mu;
    for (int i = 0; i < kSize[k]; ++i) g[kOffset[k] + i] = c[k].mu * c[k].direction[i];
    if (!pinned[k] && kSize[k] == 2 && c[k].size > 0.0) {
      const double turn = c[k].mu * n / c[k].size;
      m.block<2, 2>(kOffset[k], kOffset[k]) =
          turn * (Eigen::Matrix2d::Identity() - c[k].direction * c[k].direction.transpose());
    }
  }
  m += g * g.transpose() / denominator;
  split(m, d);
}

Reaction project(const FrictionCone& cone, const ConeFace* face, const Reaction& a,
                 ReactionDerivative* d) {
  Component c[3];
  load(cone, a, c);
  const int count = cone.has_moment() ? 3 : 1;
  bool pinned[3] = {false, false, false};
  if (face != nullptr) {
    pinned[0] = face->slides;
    pinned[1] = face->spins;
    pinned[2] = face->rolls;
    if (face->slides) slip_against(c[0], face->slide_direction);
    if (face->spins) slip_against(c[1], Vec2(face->spin_direction, 0.0));
    if (face->rolls) slip_against(c[2], face->roll_direction);
  }
  for (int k = 0; k < count; ++k) {
    if (!pinned[k]) measure(c[k]);
  }
  const double n = normal_of_projection(a.force[0], c, count);
  if (!(n > 0.0)) {
    set_zero(d);
    return {};
  }
  if (d != nullptr) projection_derivative(n, c, pinned, count, d);
  return gather(n, c, count);
}

Reaction project_force(double mu, const Vec3& a, ReactionDerivative* d) {
  return {project_on_plain_cone(mu, a, d != nullptr ? &d->ff : nullptr), Vec3::Zero()};
}

Reaction alart_curnier_force(double mu, const Vec3& a, ReactionDerivative* d) {
  const double n = a[0];
  if (!(n > 0.0)) {
    if (d != nullptr) d->ff.setZero();
    return {};
  }
  const double size = a.tail<2>().norm();
  if (size <= mu * n) {
    if (d != nullptr) d->ff.setIdentity();
    return {a, Vec3::Zero()};
  }
  const Vec2 e = a.tail<2>() / size;
  if (d != nullptr) {
    d->ff.setZero();
    d->ff(0, 0) = 1.0;
    d->ff.bottomLeftCorner<2, 1>() = mu * e;
    d->ff.bottomRightCorner<2, 2>() =
        (mu * n / size) * (Eigen::Matrix2d::Identity() - e * e.transpose());
  }
  return {Vec3(n, mu * n * e[0], mu * n * e[1]), Vec3::Zero()};
}

}  // namespace

Reaction project_on_cone(const FrictionCone& cone, const Reaction& a, ReactionDerivative* d) {
  if (!cone.has_moment()) return project_force(cone.slide, a.force, d);
  return project(cone, nullptr, a, d);
}

Reaction project_on_face(const FrictionCone& cone, const ConeFace& face, const Reaction& a,
                         ReactionDerivative* d) {
  if (face.open) {
    set_zero(d);
    return {};
  }
  if (!cone.has_moment() && !face.slides) return project_force(cone.slide, a.force, d);
  return project(cone, &face, a, d);
}

Reaction alart_curnier_map(const FrictionCone& cone, const Reaction& a, ReactionDerivative* d) {
  if (!cone.has_moment()) return alart_curnier_force(cone.slide, a.force, d);
  const double n = a.force[0];
  if (!(n > 0.0)) {
    set_zero(d);
    return {};
  }
  Component c[3];
  load(cone, a, c);
  const int count = cone.has_moment() ? 3 : 1;
  for (int k = 0; k < count; ++k) {
    measure(c[k]);
    c[k].at_bound = c[k].size > c[k].mu * n;
  }
  if (d != nullptr) {
    Eigen::Matrix<double, 6, 6> m = Eigen::Matrix<double, 6, 6>::Zero();
    m(0, 0) = 1.0;
    for (int k = 0; k < count; ++k) {
      for (int i = 0; i < kSize[k]; ++i) {
        const int row = kOffset[k] + i;
        if (!c[k].at_bound) {
          m(row, row) = 1.0;
          continue;
        }
        m(row, 0) = c[k].mu * c[k].direction[i];
        if (kSize[k] == 1) continue;
        for (int j = 0; j < kSize[k]; ++j) {
          m(row, kOffset[k] + j) = c[k].mu * n / c[k].size *
                                   ((i == j ? 1.0 : 0.0) - c[k].direction[i] * c[k].direction[j]);
        }
      }
    }
    split(m, d);
  }
  return gather(n, c, count);
}

Reaction de_saxce(const FrictionCone& cone, const Reaction& slip) {
  Reaction s = slip;
  s.force[0] += cone.slide * slip.force.tail<2>().norm();
  if (cone.has_moment()) {
    s.force[0] += cone.spin * std::abs(slip.moment[0]) + cone.roll * slip.moment.tail<2>().norm();
  }
  return s;
}

FrictionCone cone_with_moments(const ContactProblem& problem, const ContactConstraint& c,
                               double slide) {
  FrictionCone cone;
  cone.slide = slide;
  // Radius of gyration of A: a length of the body, so that the scaled problem has no units.
  const double trace = problem.inv_inertia[c.a].trace();
  if (!(trace > 0.0)) return cone;
  cone.length = std::sqrt(3.0 * problem.inv_mass[c.a] / trace);
  cone.spin = c.spinning_friction / cone.length;
  cone.roll = c.rolling_friction / cone.length;
  return cone;
}

void friction_cones(const ContactProblem& problem, Friction which, std::vector<FrictionCone>& out) {
  out.clear();
  for (const ContactConstraint& c : problem.contacts) {
    out.push_back(friction_cone(problem, c, which));
  }
}

}  // namespace rb
