// Rotations by matrix and by quaternion (S3, S5), both forms of the notes.
#pragma once

#include "math/types.hpp"

namespace rb {

// Skew(u) r = u x r (S3).
Mat3 skew(const Vec3& u);

// dR/dt = Skew(omega) R (S3); omega in rad/s, world axes.
Mat3 rotation_derivative(const Mat3& r, const Vec3& omega);

// dq/dt = 1/2 omega q with omega as a pure quaternion (S5); (x, y, z, w) as a Vec4.
Eigen::Vector4d quaternion_derivative(const Quat& q, const Vec3& omega);

// Columns made orthonormal in order, the third as the cross product (S3): drift removal for R.
// Throws std::invalid_argument when the first two columns are parallel or zero.
Mat3 gram_schmidt(const Mat3& r);

// R(q) of a unit quaternion, and the quaternion (w >= 0) of a rotation matrix.
Mat3 rotation_matrix(const Quat& q);
Quat quaternion_from_matrix(const Mat3& r);

// Rotation by |v| rad about v, exact for any length: exp(v/2) as a quaternion, and its inverse (|v|
// <= pi).
Quat quaternion_from_rotation_vector(const Vec3& v);
Vec3 rotation_vector(const Quat& q);

// q / |q| with one division; |q| must not be zero.
Quat normalized(const Quat& q);

// Two unit tangents t1, t2 with (n, t1, t2) right-handed. A fixed function of n alone, so that a
// contact keeps its frame while its normal does. Rows of the result: n, t1, t2.
inline Mat3 contact_frame(const Vec3& n) {
  // Duff et al. 2017, "Building an orthonormal basis, revisited": no branch on a near-tie but the
  // sign of n_z.
  const double sign = n.z() < 0.0 ? -1.0 : 1.0;
  const double a = -1.0 / (sign + n.z());
  const double b = n.x() * n.y() * a;
  Mat3 frame;
  frame.row(0) = n;
  frame.row(1) << 1.0 + sign * n.x() * n.x() * a, sign * b, -sign * n.x();
  frame.row(2) << b, sign + n.y() * n.y() * a, -n.y();
  return frame;
}

}  // namespace rb
