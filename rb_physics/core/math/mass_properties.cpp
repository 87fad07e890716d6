#include "math/mass_properties.hpp"

#include <algorithm>
#include <cmath>

namespace rb {

namespace {

// m (|d|^2 1 - d d^T): inertia of a point mass at d.
Mat3 point_inertia(double mass, const Vec3& d) {
  return mass * (d.squaredNorm() * Mat3::Identity() - d * d.transpose());
}

// One Jacobi rotation that zeroes a(p, q); Golub & Van Loan, Matrix Computations, section 8.5.
void jacobi_rotate(Mat3& a, Mat3& axes, int p, int q) {
  if (a(p, q) == 0.0) return;
  const double tau = (a(q, q) - a(p, p)) / (2.0 * a(p, q));
  const double t = (tau >= 0.0 ? 1.0 : -1.0) / (std::abs(tau) + std::sqrt(1.0 + tau * tau));
  const double c = 1.0 / std::sqrt(1.0 + t * t);
  const double s = t * c;
  Mat3 rotation = Mat3::Identity();
  rotation(p, p) = c;
  rotation(q, q) = c;
  rotation(p, q) = s;
  rotation(q, p) = -s;
  a = rotation.transpose() * a * rotation;
  a(p, q) = 0.0;
  a(q, p) = 0.0;
  axes = axes * rotation;
}

}  // namespace

MassProperties transformed(const MassProperties& part, const Pose& pose) {
  const Mat3 rotation = pose.orientation.toRotationMatrix();
  const Mat3 inertia = rotation * part.inertia * rotation.transpose();
  return {part.mass, pose.apply(part.center_of_mass), 0.5 * (inertia + inertia.transpose())};
}

MassProperties combined(const MassProperties& a, const MassProperties& b) {
  const double mass = a.mass + b.mass;
  if (!(mass > 0.0)) return {0.0, a.center_of_mass, a.inertia + b.inertia};
  const Vec3 apart = b.center_of_mass - a.center_of_mass;
  return {mass, a.center_of_mass + (b.mass / mass) * apart,
          a.inertia + b.inertia + point_inertia(a.mass * (b.mass / mass), apart)};
}

MassProperties scaled_to_mass(const MassProperties& m, double mass) {
  return {mass, m.center_of_mass, (mass / m.mass) * m.inertia};
}

PrincipalInertia principal_inertia(const Mat3& inertia) {
  Mat3 a = 0.5 * (inertia + inertia.transpose());
  if (a(0, 1) == 0.0 && a(0, 2) == 0.0 && a(1, 2) == 0.0) {
    return {a.diagonal(), Quat::Identity()};
  }
  Mat3 axes = Mat3::Identity();
  constexpr int max_sweeps = 32;  // quadratic convergence: five are typical
  for (int sweep = 0; sweep < max_sweeps; ++sweep) {
    const double off = std::abs(a(0, 1)) + std::abs(a(0, 2)) + std::abs(a(1, 2));
    if (off <= 1e-300 || off <= 1e-18 * a.diagonal().cwiseAbs().sum()) break;
    jacobi_rotate(a, axes, 0, 1);
    jacobi_rotate(a, axes, 0, 2);
    jacobi_rotate(a, axes, 1, 2);
  }
  int order[3] = {0, 1, 2};
  std::stable_sort(order, order + 3, [&](int i, int j) { return a(i, i) < a(j, j); });
  Mat3 sorted;
  Vec3 moments;
  for (int i = 0; i < 3; ++i) {
    sorted.col(i) = axes.col(order[i]);
    moments[i] = a(order[i], order[i]);
  }
  if (sorted.determinant() < 0.0) sorted.col(2) = -sorted.col(2);
  return {moments, Quat(sorted).normalized()};
}

double triangle_violation(const Vec3& moments) {
  const double largest = moments.maxCoeff();
  if (!(largest > 0.0)) return 0.0;
  const double others = moments.sum() - largest;
  return std::max(0.0, (largest - others) / largest);
}

}  // namespace rb
