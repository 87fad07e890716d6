// J and M^-1 J^T of the contact problem, applied contact by contact: nothing is stored.
//
// Slip of contact i (contact frame): u = frame (v_A + w_A x r_A - v_B - w_B x r_B) + bias, m/s, and
// spin = frame (w_A - w_B) + angular_bias, rad/s.
#pragma once

#include <vector>

#include "contact/problem.hpp"

namespace rb {

// J_i v: the slip without the bias. Use it for increments: slip(v + dv) - slip(v) would keep the
// bias's rounding.
inline Vec3 relative_motion(const ContactConstraint& c, const std::vector<Vec6>& v) {
  Vec3 w = v[c.a].head<3>() + v[c.a].tail<3>().cross(c.r_a);
  if (c.b >= 0) w -= v[c.b].head<3>() + v[c.b].tail<3>().cross(c.r_b);
  return c.frame * w;
}

inline Vec3 relative_turning(const ContactConstraint& c, const std::vector<Vec6>& v) {
  Vec3 w = v[c.a].tail<3>();
  if (c.b >= 0) w -= v[c.b].tail<3>();
  return c.frame * w;
}

inline Vec3 relative_velocity(const ContactConstraint& c, const std::vector<Vec6>& v) {
  return relative_motion(c, v) + c.bias;
}

inline Vec3 relative_spin(const ContactConstraint& c, const std::vector<Vec6>& v) {
  return relative_turning(c, v) + c.angular_bias;
}

// |v| + |omega| |r|, m/s: no point at r is faster. Keeps the norms of the body asked for last.
class SurfaceSpeed {
 public:
  explicit SurfaceSpeed(const std::vector<Vec6>& v) : v_(v) {}
  double operator()(std::int32_t body, const Vec3& r) {
    if (body != body_) {
      body_ = body;
      linear_ = v_[body].head<3>().norm();
      angular_ = v_[body].tail<3>().norm();
    }
    return linear_ + angular_ * r.norm();
  }

 private:
  const std::vector<Vec6>& v_;
  std::int32_t body_ = -1;
  double linear_ = 0.0, angular_ = 0.0;
};

// v += M^-1 J_i^T (impulse, moment), both in the contact frame.
inline void apply_impulse(const ContactProblem& p, const ContactConstraint& c, const Vec3& impulse,
                          std::vector<Vec6>& v) {
  const Vec3 f = c.frame.transpose() * impulse;
  v[c.a].head<3>() += p.inv_mass[c.a] * f;
  v[c.a].tail<3>() += p.inv_inertia[c.a] * c.r_a.cross(f);
  if (c.b >= 0) {
    v[c.b].head<3>() -= p.inv_mass[c.b] * f;
    v[c.b].tail<3>() -= p.inv_inertia[c.b] * c.r_b.cross(f);
  }
}

inline void apply_moment(const ContactProblem& p, const ContactConstraint& c, const Vec3& moment,
                         std::vector<Vec6>& v) {
  const Vec3 m = c.frame.transpose() * moment;
  v[c.a].tail<3>() += p.inv_inertia[c.a] * m;
  if (c.b >= 0) v[c.b].tail<3>() -= p.inv_inertia[c.b] * m;
}

// v = v_free + M^-1 J^T lambda, summed in index order.
inline void velocity_from_impulses(const ContactProblem& p, const std::vector<Vec3>& impulse,
                                   const std::vector<Vec3>& moment, std::vector<Vec6>& v) {
  v = p.velocity;
  for (std::size_t i = 0; i < p.contacts.size(); ++i) {
    apply_impulse(p, p.contacts[i], impulse[i], v);
    if (!moment.empty()) apply_moment(p, p.contacts[i], moment[i], v);
  }
}

// trace(W_ii) / 3: the contact's effective inverse mass, 1/kg.
inline double inverse_effective_mass(const ContactProblem& p, const ContactConstraint& c) {
  const auto side = [&p](int body, const Vec3& r) {
    const Mat3& i = p.inv_inertia[body];
    return p.inv_mass[body] + (i.trace() * r.squaredNorm() - r.dot(i * r)) / 3.0;
  };
  double w = side(c.a, c.r_a);
  if (c.b >= 0) w += side(c.b, c.r_b);
  return w;
}

}  // namespace rb
