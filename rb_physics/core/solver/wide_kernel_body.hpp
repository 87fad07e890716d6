// The kernel of wide_kernel.hpp, for the instruction set the including file has chosen: one file
// per level includes it, once.
#pragma once

#include "solver/wide_lanes.hpp"

namespace rb::wide {
namespace {

struct Frame {
  Vector n, t1, t2;
};
RB_INLINE Frame load_frame(const double* m) {
  const double* f = m + 8 * kFrame;
  return {load_vector(f), load_vector(f + 24), load_vector(f + 48)};
}
RB_INLINE Vector into(const Frame& f, Vector a) {
  return {dot(f.n, a), dot(f.t1, a), dot(f.t2, a)};
}
RB_INLINE Vector out_of(const Frame& f, Vector a) { return a.x * f.n + a.y * f.t1 + a.z * f.t2; }

struct Motion {
  Vector v, w;
};

RB_INLINE Motion gather(const double* velocity, const std::int32_t* rows) {
  Wide r[8];
  for (int l = 0; l < kLanes; ++l) r[l] = load(velocity + 8 * static_cast<std::int64_t>(rows[l]));
  transpose(r);
  return {{r[0], r[1], r[2]}, {r[3], r[4], r[5]}};
}

RB_INLINE void scatter(const Motion& m, double* velocity, const std::int32_t* rows,
                       std::int32_t nobody) {
  Wide r[8] = {m.v.x, m.v.y, m.v.z, m.w.x, m.w.y, m.w.z, all(0.0), all(0.0)};
  transpose(r);
  for (int l = 0; l < kLanes; ++l) {
    if (rows[l] != nobody) store(velocity + 8 * static_cast<std::int64_t>(rows[l]), r[l]);
  }
}

RB_INLINE Vector slip(const Motion& a, const Motion& b, Vector arm_a, Vector arm_b) {
  return (a.v + cross(a.w, arm_a)) - (b.v + cross(b.w, arm_b));
}

// Adds what the impulse f (world axes) at the slot's arms does to both bodies.
RB_INLINE void push(Motion& a, Motion& b, const double* m, Vector arm_a, Vector arm_b, Vector f) {
  a.v = a.v + load(m + 8 * kMassA) * f;
  a.w = a.w + times(m + 8 * kInertiaA, cross(arm_a, f));
  b.v = b.v - load(m + 8 * kMassB) * f;
  b.w = b.w - times(m + 8 * kInertiaB, cross(arm_b, f));
}

// Velocity of the contact point per unit impulse d, world axes.
RB_INLINE Vector response(const double* m, Vector arm_a, Vector arm_b, Vector d) {
  const Vector of_a = cross(times(m + 8 * kInertiaA, cross(arm_a, d)), arm_a);
  const Vector of_b = cross(times(m + 8 * kInertiaB, cross(arm_b, d)), arm_b);
  return (load(m + 8 * kMassA) + load(m + 8 * kMassB)) * d + (of_a + of_b);
}

void prepare(const View& s, std::int32_t begin, std::int32_t end) {
  for (std::int32_t g = begin; g < end; ++g) {
    const Group& group = s.groups[g];
    const double* m = s.manifolds + 8 * static_cast<std::int64_t>(group.manifold);
    const Frame f = load_frame(m);
    for (std::int32_t k = 0; k < group.slots; ++k) {
      double* p = s.points + 8 * kSlotRows * static_cast<std::int64_t>(group.slot + k);
      const Vector arm_a = load_vector(p + 8 * kArmA);
      const Vector arm_b = load_vector(p + 8 * kArmB);
      const Vector n = into(f, response(m, arm_a, arm_b, f.n));
      const Vector t1 = into(f, response(m, arm_a, arm_b, f.t1));
      const Vector t2 = into(f, response(m, arm_a, arm_b, f.t2));
      const Wide zero = all(0.0);
      const Mask used = load(p + 8 * kMass) > zero;
      const Wide mass = used ? n.x : zero;
      const Wide inverse = mass > zero ? all(1.0) / mass : zero;
      const Wide c1 = n.y * inverse, c2 = n.z * inverse;
      const Wide p11 = t1.y - c1 * n.y, p12 = t1.z - c1 * n.z, p22 = t2.z - c2 * n.z;
      const Wide det = p11 * p22 - p12 * p12;
      const Wide of_det = used & (det > zero) ? all(1.0) / det : zero;
      store(p + 8 * kMass, mass);
      store(p + 8 * kInverse, inverse);
      store(p + 8 * kCoupling, c1);
      store(p + 8 * (kCoupling + 1), c2);
      store(p + 8 * kPlane, p11);
      store(p + 8 * (kPlane + 1), p12);
      store(p + 8 * (kPlane + 2), p22);
      store(p + 8 * kPlaneInverse, of_det * p22);
      store(p + 8 * (kPlaneInverse + 1), -(of_det * p12));
      store(p + 8 * (kPlaneInverse + 2), of_det * p11);
      store(p + 8 * kSlipRatio, zero);
    }
  }
}

// One contact while all others hold (local_solver.hpp). The slip ratio beta of a sliding contact is
// found by a fixed-point iteration that goes on from sweep to sweep: a direction for the ratio, the
// impulse at the bound that stops the normal speed, the ratio it leaves.
RB_INLINE Vector solve_slot(double* p, Vector u, Vector l) {
  constexpr int steps = 2;
  const Wide zero = all(0.0), one = all(1.0);
  const Wide mu = load(p + 8 * kFriction);
  const Wide w_nn = load(p + 8 * kMass);
  const Wide c1 = load(p + 8 * kCoupling), c2 = load(p + 8 * (kCoupling + 1));
  const Wide p11 = load(p + 8 * kPlane), p12 = load(p + 8 * (kPlane + 1));
  const Wide p22 = load(p + 8 * (kPlane + 2));

  // Without this contact's impulse, in impulses: it closes if a > 0.
  const Wide normal = u.x * load(p + 8 * kInverse);
  const Wide a = (l.x + c1 * l.y + c2 * l.z) - normal;
  // Tangential slip with the normal speed stopped by the normal impulse.
  const Wide slip1 = u.y - normal * (w_nn * c1);
  const Wide slip2 = u.z - normal * (w_nn * c2);

  const Wide i12 = load(p + 8 * (kPlaneInverse + 1));
  const Wide stick1 = l.y - (load(p + 8 * kPlaneInverse) * slip1 + i12 * slip2);
  const Wide stick2 = l.z - (i12 * slip1 + load(p + 8 * (kPlaneInverse + 2)) * slip2);
  const Wide stick_n = a - (c1 * stick1 + c2 * stick2);
  const Wide limit = mu * stick_n;
  const Mask sticks = (stick_n > zero) & (stick1 * stick1 + stick2 * stick2 <= limit * limit);

  const Mask closed = a > zero;  // false in lanes left over
  if (none(closed & ~sticks)) {  // nobody slides
    store(p + 8 * kSlipRatio, zero);
    return {closed ? stick_n : zero, closed ? stick1 : zero, closed ? stick2 : zero};
  }
  const Wide q1 = slip1 - (p11 * l.y + p12 * l.z);
  const Wide q2 = slip2 - (p12 * l.y + p22 * l.z);
  const Wide plain = l.x - normal;
  Wide beta = load(p + 8 * kSlipRatio);
  Wide n, s1, s2;
  for (int k = 0; k < steps; ++k) {
    const Wide x1 = p12 * q2 - (p22 + beta) * q1;
    const Wide x2 = p12 * q1 - (p11 + beta) * q2;
    const Wide size = square_root(x1 * x1 + x2 * x2);
    const Wide inverse = size > zero ? one / size : zero;
    const Wide e1 = x1 * inverse, e2 = x2 * inverse;
    const Wide k_n = one + mu * (c1 * e1 + c2 * e2);
    const Wide aimed = k_n > all(0.25) ? a / k_n : plain;
    n = aimed > zero ? aimed : zero;
    const Wide s = mu * n;
    s1 = s * e1;
    s2 = s * e2;
    const Wide left1 = q1 + (p11 * s1 + p12 * s2);
    const Wide left2 = q2 + (p12 * s1 + p22 * s2);
    const Wide against = -(left1 * e1 + left2 * e2);
    beta = (against > zero) & (s > zero) ? against / s : zero;
  }
  store(p + 8 * kSlipRatio, sticks ? zero : beta);
  Vector next{sticks ? stick_n : n, sticks ? stick1 : s1, sticks ? stick2 : s2};
  next.x = closed ? next.x : zero;
  next.y = closed ? next.y : zero;
  next.z = closed ? next.z : zero;
  return next;
}

// Group after group: the bodies of eight manifolds are read, change by the impulses (world axes)
// that solve(frame, slot's rows, its impulse, slip) gives point by point, and are written.
template <class Base, class Solve>
RB_INLINE void for_points(const View& s, std::int32_t begin, std::int32_t end, const Base& base,
                          const Solve& solve) {
  for (std::int32_t i = begin; i < end; ++i) {
    const Group& group = s.groups[i];
    const double* m = s.manifolds + 8 * static_cast<std::int64_t>(group.manifold);
    const auto frame = base(m);
    Motion a = gather(s.velocity, group.a);
    Motion b = gather(s.velocity, group.b);
    for (std::int32_t j = 0; j < group.slots; ++j) {
      const std::int64_t slot = group.slot + j;
      double* p = s.points + 8 * kSlotRows * slot;
      const Vector arm_a = load_vector(p + 8 * kArmA);
      const Vector arm_b = load_vector(p + 8 * kArmB);
      push(a, b, m, arm_a, arm_b, solve(frame, p, s.impulse + 24 * slot, slip(a, b, arm_a, arm_b)));
    }
    scatter(a, s.velocity, group.a, s.nobody);
    scatter(b, s.velocity, group.b, s.nobody);
  }
}

void apply(const View& s, std::int32_t begin, std::int32_t end) {
  for_points(s, begin, end, load_frame, [](const Frame& f, double*, double* lambda, Vector) {
    return out_of(f, load_vector(lambda));
  });
}

void sweep(const View& s, std::int32_t begin, std::int32_t end) {
  for_points(s, begin, end, load_frame, [](const Frame& f, double* p, double* lambda, Vector slip) {
    const Vector l = load_vector(lambda);
    const Vector next = solve_slot(p, into(f, slip) + load_vector(p + 8 * kBias), l);
    store(lambda, next.x);
    store(lambda + 8, next.y);
    store(lambda + 16, next.z);
    return out_of(f, next - l);
  });
}

void sweep_frictionless(const View& s, std::int32_t begin, std::int32_t end) {
  const auto normal = [](const double* m) { return load_vector(m + 8 * kFrame); };
  for_points(s, begin, end, normal, [](Vector n, double* p, double* lambda, Vector slip) {
    const Wide l = load(lambda);
    const Wide step = l - (dot(n, slip) + load(p + 8 * kBias)) * load(p + 8 * kInverse);
    const Wide next = step > all(0.0) ? step : all(0.0);
    store(lambda, next);
    return (next - l) * n;
  });
}

// See residual.cpp: the same natural map and scale, for cones without moments.
void measure_free(const View& s, std::int32_t begin, std::int32_t end, double noise, Measure* out) {
  const Wide zero = all(0.0);
  Wide typical = zero;
  for (std::int32_t g = begin; g < end; ++g) {
    const Group& group = s.groups[g];
    const double* m = s.manifolds + 8 * static_cast<std::int64_t>(group.manifold);
    const Vector n = load_vector(m + 8 * kFrame);
    const Motion a = gather(s.velocity_free, group.a);
    const Motion b = gather(s.velocity_free, group.b);
    const Wide v_a = norm(a.v), w_a = norm(a.w), v_b = norm(b.v), w_b = norm(b.w);
    for (std::int32_t k = 0; k < group.slots; ++k) {
      const double* p = s.points + 8 * kSlotRows * static_cast<std::int64_t>(group.slot + k);
      const Vector arm_a = load_vector(p + 8 * kArmA);
      const Vector arm_b = load_vector(p + 8 * kArmB);
      const Wide approach = -(dot(n, slip(a, b, arm_a, arm_b)) + load(p + 8 * kBias));
      const Wide surface = (v_a + w_a * norm(arm_a)) + (v_b + w_b * norm(arm_b));
      const Wide speed = greater(approach, all(noise) * surface);
      typical = load(p + 8 * kMass) > zero ? greater(speed, typical) : typical;
    }
  }
  *out = {0.0, greatest_lane(typical), 0.0};
}

void measure(const View& s, std::int32_t begin, std::int32_t end, Measure* out) {
  const Wide zero = all(0.0);
  Wide worst = zero, typical = zero, operand = zero;
  for (std::int32_t g = begin; g < end; ++g) {
    const Group& group = s.groups[g];
    const double* m = s.manifolds + 8 * static_cast<std::int64_t>(group.manifold);
    const Frame f = load_frame(m);
    const Motion a = gather(s.velocity, group.a);
    const Motion b = gather(s.velocity, group.b);
    const Wide v_a = norm(a.v), w_a = norm(a.w), v_b = norm(b.v), w_b = norm(b.w);
    for (std::int32_t k = 0; k < group.slots; ++k) {
      const std::int64_t slot = group.slot + k;
      const double* p = s.points + 8 * kSlotRows * slot;
      const Vector arm_a = load_vector(p + 8 * kArmA);
      const Vector arm_b = load_vector(p + 8 * kArmB);
      const Vector u = into(f, slip(a, b, arm_a, arm_b)) + load_vector(p + 8 * kBias);
      const Wide w_nn = load(p + 8 * kMass);
      const Mask used = w_nn > zero;
      const Wide c1 = load(p + 8 * kCoupling), c2 = load(p + 8 * (kCoupling + 1));
      const Wide plane = load(p + 8 * kPlane) + load(p + 8 * (kPlane + 2));
      const Wide w = (w_nn + (plane + w_nn * (c1 * c1 + c2 * c2))) * all(1.0 / 3.0);
      const Vector l = w * load_vector(s.impulse + 24 * slot);
      const Wide mu = load(p + 8 * kFriction);
      // Projection of w l - u~ on the cone.
      const Wide x = l.x - (u.x + mu * square_root(u.y * u.y + u.z * u.z));
      const Wide y = l.y - u.y;
      const Wide z = l.z - u.z;
      const Wide t = square_root(y * y + z * z);
      const Mask inside = (x >= zero) & (t <= mu * x);
      const Wide onto = (x + mu * t) / (all(1.0) + mu * mu);
      const Wide cut = onto > zero ? onto : zero;
      const Wide n = inside ? x : cut;
      const Wide scale = inside ? all(1.0) : (t > zero ? mu * cut / t : zero);
      const Vector r = l - Vector{n, scale * y, scale * z};
      const Wide miss = used ? dot(r, r) : zero;
      worst = miss <= worst ? worst : miss;  // keeps NaN
      typical = used ? greater(dot(l, l), typical) : typical;
      const Wide reach_a = v_a + w_a * norm(arm_a), reach_b = v_b + w_b * norm(arm_b);
      operand = used ? greater(greater(reach_a, reach_b), operand) : operand;
    }
  }
  double miss = worst[0];
  for (int l = 1; l < kLanes; ++l) miss = worst[l] <= miss ? miss : worst[l];
  *out = {__builtin_sqrt(miss), __builtin_sqrt(greatest_lane(typical)), greatest_lane(operand)};
}

// Eight sums side by side, then pairwise.
double difference_sq(const double* x, const double* y, std::int64_t begin, std::int64_t end) {
  Wide s = all(0.0);
  for (std::int64_t i = begin; i < end; i += kLanes) {
    const Wide d = load(x + i) - load(y + i);
    s = s + d * d;
  }
  return ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
}

void extrapolate(double* x, double* last, double* direction, double beta, std::int64_t begin,
                 std::int64_t end) {
  for (std::int64_t i = begin; i < end; i += kLanes) {
    const Wide push = all(beta) * load(direction + i);
    const Wide here = load(x + i);
    const Wide next = here + push;
    store(direction + i, push + (here - load(last + i)));
    store(x + i, next);
    store(last + i, next);
  }
}

constexpr Kernel make_kernel(const char* level) {
  return {level,        prepare, apply,         sweep,      sweep_frictionless,
          measure_free, measure, difference_sq, extrapolate};
}

}  // namespace
}  // namespace rb::wide
