#include "math/rotation.hpp"

#include <cmath>
#include <stdexcept>

#include "math/elementary.hpp"

namespace rb {

Mat3 skew(const Vec3& u) {
  Mat3 m;
  m << 0.0, -u.z(), u.y(),  //
      u.z(), 0.0, -u.x(),   //
      -u.y(), u.x(), 0.0;
  return m;
}

Mat3 rotation_derivative(const Mat3& r, const Vec3& omega) { return skew(omega) * r; }

Eigen::Vector4d quaternion_derivative(const Quat& q, const Vec3& omega) {
  const Quat w(0.0, omega.x(), omega.y(), omega.z());
  return 0.5 * (w * q).coeffs();
}

Mat3 gram_schmidt(const Mat3& r) {
  const Vec3 u0 = r.col(0);
  const double n0 = u0.norm();
  if (!(n0 > 0.0)) throw std::invalid_argument("gram_schmidt: the first column is zero");
  const Vec3 e0 = u0 / n0;
  const Vec3 u1 = r.col(1) - r.col(1).dot(e0) * e0;
  const double n1 = u1.norm();
  if (!(n1 > 1e-14 * r.col(1).norm())) {
    throw std::invalid_argument("gram_schmidt: the first two columns are parallel");
  }
  const Vec3 e1 = u1 / n1;
  Mat3 out;
  out.col(0) = e0;
  out.col(1) = e1;
  out.col(2) = e0.cross(e1);
  return out;
}

Mat3 rotation_matrix(const Quat& q) { return q.toRotationMatrix(); }

Quat quaternion_from_matrix(const Mat3& r) {
  Quat q(r);
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  return normalized(q);
}

Quat quaternion_from_rotation_vector(const Vec3& v) {
  const double sq = v.squaredNorm();
  double f = 0.0, cosine = 0.0;  // sin(a/2)/a, cos(a/2)
  if (sq < 1e-4) {               // their series, to rounding: most bodies turn by less in a step
    f = 0.5 - sq * (1.0 / 48.0 - sq * (1.0 / 3840.0));
    cosine = 1.0 - sq * (1.0 / 8.0 - sq * (1.0 / 384.0 - sq * (1.0 / 46080.0)));
  } else {
    const double angle = std::sqrt(sq);
    const SinCos half = sin_cos(0.5 * angle);
    f = half.sin / angle;
    cosine = half.cos;
  }
  return Quat(cosine, f * v.x(), f * v.y(), f * v.z());
}

Vec3 rotation_vector(const Quat& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const double s = q.vec().norm();
  const double angle = 2.0 * atan2(s, sign * q.w());
  const double f = s > 1e-12 ? angle / s : 2.0;
  return sign * f * q.vec();
}

Quat normalized(const Quat& q) {
  Quat out;
  out.coeffs() = q.coeffs() * (1.0 / std::sqrt(q.coeffs().squaredNorm()));
  return out;
}

}  // namespace rb
