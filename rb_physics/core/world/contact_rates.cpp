#include "world/contact_rates.hpp"

#include <cmath>

#include "collision/feature.hpp"
#include "world/step.hpp"

namespace rb {
namespace {

BodyMotion motion_of(const Body& body) {
  BodyMotion m;
  m.center = body.state.x;
  m.velocity = body.linear_velocity();
  m.angular_velocity = body.angular_velocity();
  return m;
}

BodyMotion motion_with_forces(const World& world, const Body& body) {
  BodyMotion m = motion_of(body);
  if (!body.is_dynamic()) return m;
  Wrench w = external_wrench(world, body);
  w.force += body.contact_impulse / world.settings.dt;
  w.torque += body.contact_moment / world.settings.dt;
  m.acceleration = body.inertia.inv_mass * w.force;
  m.angular_acceleration = world_inverse_inertia(body.state.q, body.inertia) *
                           (w.torque - m.angular_velocity.cross(body.state.L));
  return m;
}

ContactKinematics rates(const World& world, const Contact& c, const BodyMotion& a,
                        const BodyMotion& b, ContactSurface& surface_a, ContactSurface& surface_b) {
  const Collider& ca = world.colliders[c.collider_a];
  const Collider& cb = world.colliders[c.collider_b];
  surface_a = contact_surface(ca.shape, world.bodies[c.body_a].pose() * ca.local,
                              feature_of_a(c.point.feature), -c.point.normal);
  surface_b = contact_surface(cb.shape, world.bodies[c.body_b].pose() * cb.local,
                              feature_of_b(c.point.feature), c.point.normal);
  return contact_kinematics(c.point, surface_a, a, surface_b, b);
}

// What makes the points of both bodies the same again: s e_a - t e_b = lag, in the tangent plane.
void wander_along_lines(const Vec3& lag, const Vec3& line_a, const Vec3& line_b, Vec3& wander_a,
                        Vec3& wander_b) {
  const double sa = line_a.dot(lag), sb = line_b.dot(lag);
  const double cosine = line_a.dot(line_b);
  const double sine_sq = line_a.squaredNorm() * line_b.squaredNorm() - cosine * cosine;
  if (sine_sq > 1e-12) {
    wander_a += (sa - cosine * sb) / sine_sq * line_a;
    wander_b += (cosine * sa - sb) / sine_sq * line_b;
  } else {
    // Along two parallel lines no point is marked: half way between those of the bodies.
    const double share = cosine == 0.0 ? 1.0 : 0.5;
    wander_a += share * sa * line_a;
    wander_b -= share * sb * line_b;
  }
}

}  // namespace

ContactKinematics contact_rates(const World& world, const Contact& c) {
  ContactSurface surface_a, surface_b;
  return rates(world, c, motion_with_forces(world, world.bodies[c.body_a]),
               motion_with_forces(world, world.bodies[c.body_b]), surface_a, surface_b);
}

ContactDrift contact_drift(const World& world, const Contact& c) {
  const BodyMotion a = motion_of(world.bodies[c.body_a]);
  const BodyMotion b = motion_of(world.bodies[c.body_b]);
  ContactSurface surface_a, surface_b;
  const ContactKinematics k = rates(world, c, a, b, surface_a, surface_b);
  const Vec3 point = 0.5 * (c.point.point_a + c.point.point_b);
  const Vec3 velocity_a = a.point_velocity(point);
  const Vec3 velocity_b = b.point_velocity(point);
  // The contact wanders over a curved surface as the normal turns against the body; over a face it
  // goes where the other body's feature takes it, along an edge where the other body's point does.
  Vec3 wander_a = -surface_a.radii * (k.normal_rate - a.angular_velocity.cross(c.point.normal));
  Vec3 wander_b = surface_b.radii * (k.normal_rate - b.angular_velocity.cross(c.point.normal));
  if (c.point.normal_owner == NormalOwner::A) {
    wander_a = velocity_b + wander_b - velocity_a;
  } else if (c.point.normal_owner == NormalOwner::B) {
    wander_b = velocity_a + wander_a - velocity_b;
  } else {
    const Vec3 lag = velocity_b + wander_b - velocity_a - wander_a;
    wander_along_lines(lag, surface_a.line, surface_b.line, wander_a, wander_b);
  }
  ContactDrift drift;
  drift.normal_rate = k.normal_rate;
  drift.point_rate = 0.5 * (velocity_a + wander_a + velocity_b + wander_b);
  const Vec3 r_a = point - a.center;
  const Vec3 r_b = point - b.center;
  drift.velocity_rate = a.angular_velocity.cross(a.angular_velocity.cross(r_a) + wander_a) -
                        b.angular_velocity.cross(b.angular_velocity.cross(r_b) + wander_b);
  return drift;
}

}  // namespace rb
