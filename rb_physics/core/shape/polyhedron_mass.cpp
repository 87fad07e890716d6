#include "shape/polyhedron_mass.hpp"

#include <cmath>

namespace rb {

MassProperties polyhedron_mass(const std::vector<Vec3>& vertices,
                               const std::vector<std::array<int, 3>>& triangles) {
  // About the mean of the vertices, so that a body far from its origin loses nothing.
  Vec3 origin = Vec3::Zero();
  for (const Vec3& v : vertices) origin += v / static_cast<double>(vertices.size());
  double volume_6 = 0.0;
  Vec3 first_24 = Vec3::Zero();
  Mat3 second_120 = Mat3::Zero();
  for (const auto& t : triangles) {
    const Vec3 a = vertices[t[0]] - origin, b = vertices[t[1]] - origin,
               c = vertices[t[2]] - origin;
    const double det = a.dot(b.cross(c));
    const Vec3 sum = a + b + c;
    volume_6 += det;
    first_24 += det * sum;
    second_120 +=
        det * (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
  }
  const double mass = volume_6 / 6.0;
  if (!(std::abs(mass) > 0.0)) return {mass, origin, Mat3::Zero()};  // flat: no inside
  const Vec3 center = first_24 / (24.0 * mass);
  const Mat3 covariance = second_120 / 120.0 - mass * center * center.transpose();
  const Mat3 inertia = covariance.trace() * Mat3::Identity() - covariance;
  return {mass, origin + center, 0.5 * (inertia + inertia.transpose())};
}

}  // namespace rb
