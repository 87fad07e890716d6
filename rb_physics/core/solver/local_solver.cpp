#include "solver/local_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rb {
namespace {

constexpr double kRounding = 4e-16;  // a finer search would only follow the rounding

// lambda_t(beta) in the eigenbasis of W~ (2x2, symmetric).
struct TangentialPlane {
  double d1, d2;  // eigenvalues
  Vec2 e1, e2;
  double q1, q2;

  TangentialPlane(const Eigen::Matrix2d& w, const Vec2& q) {
    const double mean = 0.5 * (w(0, 0) + w(1, 1));
    const double half = 0.5 * (w(0, 0) - w(1, 1));
    const double off = w(0, 1);
    const double radius = std::sqrt(half * half + off * off);
    d1 = mean + radius;
    d2 = std::max(mean - radius, 0.0);
    // Eigenvector of d1 from the better conditioned row.
    Vec2 e = half >= 0.0 ? Vec2(half + radius, off) : Vec2(off, radius - half);
    const double n = e.norm();
    e1 = n > 0.0 ? Vec2(e / n) : Vec2(1.0, 0.0);
    e2 = Vec2(-e1[1], e1[0]);
    q1 = q.dot(e1);
    q2 = q.dot(e2);
  }
  Vec2 lambda(double beta) const { return -(q1 / (d1 + beta)) * e1 - (q2 / (d2 + beta)) * e2; }
};

// -W^-1 q by Cholesky; NaN where W is not positive definite.
Vec3 stick(const Mat3& w, const Vec3& q) {
  const double i0 = 1.0 / std::sqrt(w(0, 0));
  const double l10 = w(1, 0) * i0, l20 = w(2, 0) * i0;
  const double i1 = 1.0 / std::sqrt(w(1, 1) - l10 * l10);
  const double l21 = (w(2, 1) - l20 * l10) * i1;
  const double i2 = 1.0 / std::sqrt(w(2, 2) - l20 * l20 - l21 * l21);
  const double y0 = -q[0] * i0;
  const double y1 = (-q[1] - l10 * y0) * i1;
  const double y2 = (-q[2] - l20 * y0 - l21 * y1) * i2;
  const double x2 = y2 * i2;
  const double x1 = (y1 - l21 * x2) * i1;
  return {(y0 - l10 * x1 - l20 * x2) * i0, x1, x2};
}

Vec3 slide(const Mat3& w, const Vec3& q, double mu) {
  const double inv_nn = 1.0 / w(0, 0);
  const Vec2 w_tn = w.block<2, 1>(1, 0);
  const TangentialPlane plane(w.block<2, 2>(1, 1) - w_tn * w_tn.transpose() * inv_nn,
                              q.tail<2>() - w_tn * (q[0] * inv_nn));
  const auto normal = [&](const Vec2& t) { return -(q[0] + w_tn.dot(t)) * inv_nn; };
  // mu lambda_n / |lambda_t| = 1: below 1 at beta = 0 (no stick), above at a large beta, and linear
  // where w is isotropic: Newton's method, kept in the bracket.
  double low = 0.0;
  double high = std::numeric_limits<double>::infinity();
  const double free_normal = -q[0] * inv_nn;
  double beta = Vec2(plane.q1, plane.q2).norm() / (mu * free_normal) - 0.5 * (plane.d1 + plane.d2);
  if (!(beta > 0.0)) beta = plane.d1 > 0.0 ? 0.01 * plane.d1 : w(0, 0);
  for (int k = 0; k < 100; ++k) {
    const double s1 = 1.0 / (plane.d1 + beta), s2 = 1.0 / (plane.d2 + beta);
    const double x1 = plane.q1 * s1, x2 = plane.q2 * s2;
    const double size = std::sqrt(x1 * x1 + x2 * x2);
    const Vec2 rate = (x1 * s1) * plane.e1 + (x2 * s2) * plane.e2;  // of lambda_t
    const double n = normal(-x1 * plane.e1 - x2 * plane.e2);
    const double excess = size - mu * n;
    if (excess == 0.0) break;
    (excess > 0.0 ? low : high) = beta;
    const double size_rate = -(x1 * x1 * s1 + x2 * x2 * s2) / size;
    const double slope = (-w_tn.dot(rate) * inv_nn * size - n * size_rate) * mu / (size * size);
    double next = beta + excess / (size * slope);
    if (!(next > low && next < high)) {
      next = high < std::numeric_limits<double>::infinity() ? 0.5 * (low + high)
                                                            : 4.0 * (beta + plane.d1);
    }
    const bool settled = std::abs(next - beta) <= kRounding * (plane.d1 + beta);
    beta = next;
    if (settled) break;
  }
  const Vec2 t = plane.lambda(beta);
  // On the cone exactly: length from lambda_n, direction from t. u_n = 0 with that direction.
  const double size = t.norm();
  if (!(size > 0.0)) return {normal(t), 0.0, 0.0};
  const Vec2 e = t / size;
  const double stiffness = w(0, 0) + mu * w_tn.dot(e);
  const double n = stiffness > 1e-12 * w(0, 0) ? -q[0] / stiffness : normal(t);
  return {n, mu * n * e[0], mu * n * e[1]};
}

}  // namespace

Vec2 solve_local_slip(const Eigen::Matrix2d& w, const Vec2& q, double bound) {
  const TangentialPlane plane(w, q);
  if (!(bound > 0.0)) return Vec2::Zero();
  if (plane.d2 > 0.0) {
    const Vec2 stick = plane.lambda(0.0);
    if (stick.norm() <= bound) return stick;
  }
  // |lambda(beta)| falls from above the bound: beta = |u| / bound solves it for an isotropic w.
  double low = 0.0;
  double high = q.norm() / bound;  // there |lambda| <= |q| / high = bound
  double beta = high;
  for (int k = 0; k < 100; ++k) {
    // Newton on 1/|lambda| - 1/bound, concave in beta and nearly linear; kept in the bracket.
    const Vec2 t = plane.lambda(beta);
    const double size = t.norm();
    (size > bound ? low : high) = beta;
    const double x1 = plane.q1 / (plane.d1 + beta);
    const double x2 = plane.q2 / (plane.d2 + beta);
    const double slope = (x1 * x1 / (plane.d1 + beta) + x2 * x2 / (plane.d2 + beta)) / size;
    double next = beta + (size - bound) * size / (bound * slope);
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const bool settled = std::abs(next - beta) <= kRounding * (plane.d1 + beta);
    beta = next;
    if (settled) break;
  }
  const Vec2 t = plane.lambda(beta);
  return t * (bound / t.norm());
}

Vec3 solve_local_contact(const Mat3& w, const Vec3& q, double mu) {
  if (!(q[0] < 0.0)) return Vec3::Zero();
  if (mu == 0.0) return {-q[0] / w(0, 0), 0.0, 0.0};
  const Vec3 stuck = stick(w, q);
  if (stuck[0] > 0.0 && stuck.tail<2>().squaredNorm() <= mu * mu * stuck[0] * stuck[0]) {
    return stuck;
  }
  return slide(w, q, mu);
}

}  // namespace rb
