#include "body/free_motion.hpp"

#include <array>
#include <cmath>

#include "math/rotation.hpp"

namespace rb {
namespace {

constexpr int max_order = 24;
constexpr double max_angle = 0.25;    // rad turned per series: keeps the order below about 14
constexpr double many_turns = 64.0;   // rad: from here on pieces follow the speed of the moment
constexpr int most_pieces = 65536;    // more than `greatest_turn` takes
constexpr double negligible = 1e-19;  // relative size of the last term, a thousandth of rounding

// One Taylor series over h with |omega| h <= max_angle.
Quat series(const Quat& q, const Vec3& L, const Inertia& in, double h) {
  std::array<Vec3, max_order + 1> l;      // coefficients times h^k
  std::array<Vec3, max_order + 1> omega;  // h J_b^-1 l
  std::array<Quat, max_order + 1> dq;     // of the relative rotation q(0)^-1 q(t)
  l[0] = q.conjugate() * L;
  omega[0] = h * (in.inv_body * l[0]);
  dq[0] = Quat::Identity();
  const double l_scale = l[0].norm();
  int order = 0;
  for (int k = 0; k < max_order; ++k) {
    Vec3 cross = Vec3::Zero();
    Vec3 vec = Vec3::Zero();
    double w = 0.0;
    for (int j = 0; j <= k; ++j) {
      const Vec3& o = omega[k - j];
      cross += l[j].cross(o);
      w -= dq[j].vec().dot(o);
      vec += dq[j].w() * o + dq[j].vec().cross(o);
    }
    const double f = 1.0 / (k + 1);
    l[k + 1] = f * cross;
    omega[k + 1] = h * (in.inv_body * l[k + 1]);
    dq[k + 1] = Quat(0.5 * f * w, 0.5 * f * vec.x(), 0.5 * f * vec.y(), 0.5 * f * vec.z());
    order = k + 1;
    if (dq[k + 1].coeffs().cwiseAbs().maxCoeff() < negligible &&
        l[k + 1].cwiseAbs().maxCoeff() <= negligible * l_scale) {
      break;
    }
  }
  // Smallest terms first; the large 1 of dq[0] is left to the last product, which saves its
  // rounding.
  Eigen::Vector4d delta = Eigen::Vector4d::Zero();
  for (int k = order; k >= 1; --k) delta += dq[k].coeffs();
  Quat change;
  change.coeffs() = delta;
  Quat out;
  out.coeffs() = q.coeffs() + (q * change).coeffs();
  return normalized(out);
}

// Many turns. The bound on |omega| that serves for a few may be far above it (a needle's); |omega|
// changes by a third at most within one piece, because no principal moment exceeds the sum of the
// others.
Quat turn_on(const Quat& q, const Vec3& L, const Inertia& in, double h) {
  Quat out = q;
  double left = h;
  for (int k = 0; k < most_pieces && left != 0.0; ++k) {
    const double omega = (in.inv_body * (out.conjugate() * L)).norm();
    const double piece = std::fmin(std::fabs(left), max_angle / omega);
    out = series(out, L, in, std::copysign(piece, left));
    left = piece < std::fabs(left) ? left - std::copysign(piece, left) : 0.0;
  }
  return out;
}

}  // namespace

Quat rotate_free(const Quat& q, const Vec3& L, const Inertia& in, double h) {
  if (in.isotropic) {
    const Vec3 angle = (h * in.inv_body(0, 0)) * L;
    if (angle.isZero(0.0)) return q;
    return normalized(quaternion_from_rotation_vector(angle) * q);
  }
  if (L.isZero(0.0)) return q;
  // Bounds of |omega| over the whole motion, from |L| and from the energy; the trace of J^-1 is
  // above 1 / J_min.
  const double inv_min = in.inv_body.trace();
  const Vec3 l = q.conjugate() * L;
  const double twice_energy = l.dot(in.inv_body * l);
  const double omega_max = std::fmin(l.norm() * inv_min, std::sqrt(twice_energy * inv_min));
  const double angle = std::fabs(h) * omega_max;
  if (angle > many_turns) return turn_on(q, L, in, h);
  const int pieces = angle <= max_angle ? 1 : static_cast<int>(std::ceil(angle / max_angle));
  Quat out = q;
  for (int k = 0; k < pieces; ++k) out = series(out, L, in, h / pieces);
  return out;
}

RigidState move_free(const RigidState& s, const Inertia& in, const Wrench& w, double h) {
  RigidState out;
  const Vec3 impulse = h * w.force;
  out.x = s.x + (h * in.inv_mass) * (s.p + 0.5 * impulse);
  out.p = s.p + impulse;
  const Vec3 half_kick = (0.5 * h) * w.torque;
  const Vec3 middle = s.L + half_kick;
  out.q = rotate_free(s.q, middle, in, h);
  out.L = middle + half_kick;
  return out;
}

Vec6 velocities_after(const RigidState& s, const Inertia& in, const Wrench& w, double h) {
  RigidState end;
  if (in.isotropic) {
    const Vec3 half_kick = (0.5 * h) * w.torque;
    end.p = s.p + h * w.force;
    end.L = (s.L + half_kick) + half_kick;
  } else {
    end = move_free(s, in, w, h);
  }
  Vec6 out;
  out << linear_velocity(end, in), angular_velocity(end, in);
  return out;
}

}  // namespace rb
