#include "world/pair_momentum.hpp"

#include <algorithm>
#include <cmath>

#include "math/rotation.hpp"

namespace rb {

namespace {

Mat3 world_inertia(const Body& body) {
  const Mat3 r = body.state.q.toRotationMatrix();
  return r * body.inertia.body * r.transpose();
}

bool turns(const Body& body) { return !body.inertia.inv_body.isZero(0.0); }

}  // namespace

void take_from_pair(Body& a, Body& b, Contact& contact, const Vec3& change) {
  if (change.isZero(0.0)) return;
  // In the frame of the pair's centre of mass there is one arm d = x_A - x_B and one relative
  // velocity u = v_A - v_B, with the reduced mass.
  const double reduced = 1.0 / (a.inertia.inv_mass + b.inertia.inv_mass);
  const Vec3 d = a.state.x - b.state.x;
  const Vec3 u = a.linear_velocity() - b.linear_velocity();
  const Vec3 w_a = a.angular_velocity(), w_b = b.angular_velocity();
  const Mat3 j_a = turns(a) ? world_inertia(a) : Mat3::Zero();
  const Mat3 j_b = turns(b) ? world_inertia(b) : Mat3::Zero();
  Mat3 inertia = j_a + j_b + reduced * (d.squaredNorm() * Mat3::Identity() - d * d.transpose());
  // Two points turn about no axis through both, and no `change` is along it.
  if (!turns(a) && !turns(b)) inertia += reduced * d * d.transpose();
  if (!(inertia.determinant() > 0.0)) return;
  const Mat3 inverse = inertia.inverse();
  const Vec3 before = a.state.L + b.state.L + reduced * d.cross(u);
  const Vec3 after = before - change;
  const Vec3 turn_before = inverse * before, turn_after = inverse * after;
  const Vec3 inner_u = u - turn_before.cross(d);
  const double energy = 0.5 * (a.state.L.dot(w_a) + b.state.L.dot(w_b) + reduced * u.squaredNorm());
  const double inner = energy - 0.5 * before.dot(turn_before);
  const double left = energy - 0.5 * after.dot(turn_after);
  // Of the motion inside the pair: 1 unless the turning alone would have more energy than before.
  const double keep = inner > left ? std::sqrt(std::fmax(left, 0.0) / inner) : 1.0;
  const Vec3 p = reduced * (turn_after.cross(d) + keep * inner_u - u);
  const Vec3 l_a =
      turns(a) ? Vec3(j_a * (turn_after + keep * (w_a - turn_before)) - a.state.L) : Vec3::Zero();
  // The rest, to the bit: l_A + l_B + d x p = -change.
  const Vec3 l_b = turns(b) ? Vec3(-change - d.cross(p) - l_a) : Vec3::Zero();
  a.state.p += p;
  a.state.L += l_a;
  b.state.p -= p;
  b.state.L += l_b;
  contact.impulse += p;
  contact.moment_a += l_a;
  contact.moment_b += l_b;
}

}  // namespace rb
