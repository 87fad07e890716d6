#include "solver/interior_point.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/contact_operators.hpp"
#include "solver/residual.hpp"

namespace rb {
namespace {

// The Jordan algebra of the second-order cone |x_t| <= x_n.
double determinant(const Vec3& x) {
  const double t = x.tail<2>().norm();
  return (x[0] - t) * (x[0] + t);
}

Vec3 product(const Vec3& x, const Vec3& y) {
  Vec3 r;
  r[0] = x.dot(y);
  r.tail<2>() = x[0] * y.tail<2>() + y[0] * x.tail<2>();
  return r;
}

// z with x o z = b.
Vec3 quotient(const Vec3& b, const Vec3& x) {
  Vec3 z;
  z[0] = (x[0] * b[0] - x.tail<2>().dot(b.tail<2>())) / determinant(x);
  z.tail<2>() = (b.tail<2>() - z[0] * x.tail<2>()) / x[0];
  return z;
}

// Largest step for which x + step dx stays in the cone.
double largest_step(const Vec3& x, const Vec3& dx) {
  const double root = std::sqrt(determinant(x));
  const Vec3 unit = x / root;
  const Vec3 d = dx / root;
  const double along = unit[0] * d[0] - unit.tail<2>().dot(d.tail<2>());
  const Vec2 across = d.tail<2>() - ((along + d[0]) / (unit[0] + 1.0)) * unit.tail<2>();
  const double shrink = across.norm() - along;
  return shrink > 0.0 ? 1.0 / shrink : std::numeric_limits<double>::infinity();
}

// Nesterov and Todd's W, symmetric, with W y = W^-1 x.
void nesterov_todd(const Vec3& x, const Vec3& y, Mat3& w, Mat3& inverse) {
  const double root_x = std::sqrt(determinant(x));
  const double root_y = std::sqrt(determinant(y));
  const Vec3 a = x / root_x;
  const Vec3 b = y / root_y;
  const double gamma = std::sqrt(0.5 * (1.0 + a.dot(b)));
  Vec3 p = a;
  p[0] += b[0];
  p.tail<2>() -= b.tail<2>();
  p /= 2.0 * gamma;
  const double scale = std::sqrt(root_x / root_y);
  const Eigen::Matrix2d inner =
      Eigen::Matrix2d::Identity() + p.tail<2>() * p.tail<2>().transpose() / (1.0 + p[0]);
  w(0, 0) = p[0];
  w.topRightCorner<1, 2>() = p.tail<2>().transpose();
  w.bottomLeftCorner<2, 1>() = p.tail<2>();
  w.bottomRightCorner<2, 2>() = inner;
  inverse = w;
  inverse.topRightCorner<1, 2>() *= -1.0;
  inverse.bottomLeftCorner<2, 1>() *= -1.0;
  w *= scale;
  inverse /= scale;
}

// In x = T lambda and y = T^-1 u~, T = diag(mu, 1, 1), every cone is the standard one.
struct InteriorPoint {
  const ContactProblem& problem;
  const std::vector<FrictionCone>& cones;
  BodySpace& space;
  InteriorPointWorkspace& ws;

  double factor(std::size_t i) const { return cones[i].slide > 0.0 ? cones[i].slide : 1.0; }

  Vec3 to_impulse(std::size_t i, Vec3 x) const {
    x[0] /= factor(i);
    return x;
  }

  // T^-1 times a slip; the frictionless know no tangents.
  Vec3 to_cone(std::size_t i, Vec3 u) const {
    u[0] /= factor(i);
    if (!(cones[i].slide > 0.0)) u.tail<2>().setZero();
    return u;
  }

  // J B dz, in the cone's coordinates.
  Vec3 slip_of(std::size_t i, const std::vector<Vec6>& v) const {
    const ContactConstraint& c = problem.contacts[i];
    return to_cone(i, relative_velocity(c, v) - c.bias);
  }

  void start(double u_typical) {
    const std::size_t nc = cones.size();
    ws.z.assign(problem.inv_mass.size(), Vec6::Zero());
    for (std::size_t i = 0; i < nc; ++i) {
      const ContactConstraint& c = problem.contacts[i];
      ws.x[i] = Vec3(u_typical / inverse_effective_mass(problem, c), 0.0, 0.0);
      Vec3 y = to_cone(i, relative_velocity(c, problem.velocity));
      const double t = y.tail<2>().norm();
      y[0] = std::max(y[0] + t, t + 0.3 * u_typical);
      ws.y[i] = y;
    }
  }

  // gap_of_slip = T^-1 (u + mu |u_t| n) - y at the present velocities.
  double residuals() {
    space.velocity(problem, ws.z, ws.v);
    double complementarity = 0.0;
    for (std::size_t i = 0; i < cones.size(); ++i) {
      Vec3 u = to_cone(i, relative_velocity(problem.contacts[i], ws.v));
      u[0] += u.tail<2>().norm();
      ws.gap_of_slip[i] = u - ws.y[i];
      complementarity += ws.x[i].dot(ws.y[i]);
      ws.impulse[i] = to_impulse(i, ws.x[i]);
    }
    return complementarity / static_cast<double>(cones.size());
  }

  bool factorize() {
    for (std::size_t i = 0; i < cones.size(); ++i) {
      nesterov_todd(ws.x[i], ws.y[i], ws.scaling[i], ws.inverse_scaling[i]);
      ws.scaled[i] = ws.scaling[i] * ws.y[i];
      Mat3 d = ws.scaling[i] * ws.scaling[i];
      if (cones[i].slide > 0.0) {
        d.row(0) /= cones[i].slide;
        d.col(0) /= cones[i].slide;
      } else {
        const double nn = d(0, 0);
        d.setZero();
        d(0, 0) = nn;
      }
      ws.d[i].ff = d;
    }
    return space.factorize(problem, cones, ws.d, 1.0, true);
  }

  // The Newton step towards x o y = center e (minus the second-order term of `predicted`, if any);
  // returns the largest step both cones allow.
  double direction(double center, bool corrector) {
    ws.rhs.assign(ws.z.size(), Vec6::Zero());
    for (std::size_t i = 0; i < cones.size(); ++i) {
      Vec3 goal = -product(ws.scaled[i], ws.scaled[i]);
      if (corrector) goal -= ws.predicted[i];
      goal[0] += center;
      const Mat3& w = ws.scaling[i];
      ws.shift[i] = w * (quotient(goal, ws.scaled[i]) - w * ws.gap_of_slip[i]);
      add_wrench(problem.contacts[i], cones[i],
                 {to_impulse(i, ws.x[i] + ws.shift[i]), Vec3::Zero()}, ws.rhs);
    }
    space.scale_transposed(ws.rhs, ws.dz);
    for (std::size_t i = 0; i < ws.z.size(); ++i) ws.dz[i] -= ws.z[i];
    space.solve(ws.dz);
    space.scale(ws.dz, ws.v);
    double step = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < cones.size(); ++i) {
      const Vec3 du = slip_of(i, ws.v);
      ws.dy[i] = du + ws.gap_of_slip[i];
      const Mat3& w = ws.scaling[i];
      ws.dx[i] = ws.shift[i] - w * (w * du);
      if (!(cones[i].slide > 0.0)) ws.dx[i].tail<2>().setZero();
      step = std::min({step, largest_step(ws.x[i], ws.dx[i]), largest_step(ws.y[i], ws.dy[i])});
    }
    return step;
  }

  void predict() {
    for (std::size_t i = 0; i < cones.size(); ++i) {
      ws.predicted[i] = product(ws.inverse_scaling[i] * ws.dx[i], ws.scaling[i] * ws.dy[i]);
    }
  }

  void move(double step) {
    for (std::size_t i = 0; i < ws.z.size(); ++i) ws.z[i] += step * ws.dz[i];
    for (std::size_t i = 0; i < cones.size(); ++i) {
      ws.x[i] += step * ws.dx[i];
      ws.y[i] += step * ws.dy[i];
    }
  }
};

}  // namespace

InteriorPointReport interior_point(const ContactProblem& problem, const ContactScales& scales,
                                   const std::vector<FrictionCone>& cones, double tolerance,
                                   int max_steps, BodySpace& space, InteriorPointWorkspace& ws,
                                   std::vector<Vec3>& impulse) {
  const std::size_t nc = cones.size();
  InteriorPointReport report;
  report.residual = std::numeric_limits<double>::infinity();
  for (auto* list : {&ws.x, &ws.y, &ws.dx, &ws.dy, &ws.shift, &ws.gap_of_slip, &ws.scaled,
                     &ws.predicted, &ws.impulse}) {
    list->resize(nc);
  }
  ws.scaling.resize(nc);
  ws.inverse_scaling.resize(nc);
  ws.d.assign(nc, {});
  double u = 0.0;
  for (const ContactConstraint& c : problem.contacts) {
    u = std::max(u, -relative_velocity(c, problem.velocity)[0]);
  }
  if (!(u > 0.0)) return report;
  InteriorPoint point{problem, cones, space, ws};
  point.start(u);
  const std::vector<Vec3> no_moment;
  int stuck = 0;
  for (;;) {
    const double gap = point.residuals();
    velocity_from_impulses(problem, ws.impulse, no_moment, ws.v);
    const double r =
        natural_map_residual(problem, scales, cones, ws.impulse, no_moment, ws.v).natural_map;
    if (r < report.residual) {
      report.residual = r;
      impulse = ws.impulse;
    }
    if (!(r > tolerance) || report.steps >= max_steps || stuck >= 3) return report;
    if (!point.factorize()) return report;
    const double affine = std::min(1.0, point.direction(0.0, false));
    point.predict();
    const double center = gap * std::max(1e-6, (1.0 - affine) * (1.0 - affine) * (1.0 - affine));
    const double step = std::min(1.0, 0.99 * point.direction(center, true));
    if (!(step > 0.0)) return report;
    stuck = step < 0.05 ? stuck + 1 : 0;
    point.move(step);
    ++report.steps;
  }
}

}  // namespace rb
