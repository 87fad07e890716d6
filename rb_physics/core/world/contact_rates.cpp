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
  // goes where the other body's feature takes it.
  Vec3 wander_a = -surface_a.radii * (k.normal_rate - a.angular_velocity.cross(c.point.normal));
  Vec3 wander_b = surface_b.radii * (k.normal_rate - b.angular_velocity.cross(c.point.normal));
  ContactDrift drift;
  drift.normal_rate = k.normal_rate;
  if (c.point.normal_owner == NormalOwner::A) {
    drift.point_rate = velocity_b + wander_b;
    wander_a = drift.point_rate - velocity_a;
  } else if (c.point.normal_owner == NormalOwner::B) {
    drift.point_rate = velocity_a + wander_a;
    wander_b = drift.point_rate - velocity_b;
  } else if (c.point.normal_owner == NormalOwner::EDGES) {
    // Where the edges cross: velocity_a + s e_a = velocity_b + t e_b, in the tangent plane.
    const Vec3 slip = velocity_b - velocity_a;
    const double cosine = surface_a.line.dot(surface_b.line);
    const double sine_sq = 1.0 - cosine * cosine;
    if (sine_sq > 1e-12) {
      const double sa = surface_a.line.dot(slip);
      const double sb = surface_b.line.dot(slip);
      wander_a = (sa - cosine * sb) / sine_sq * surface_a.line;
      wander_b = (cosine * sa - sb) / sine_sq * surface_b.line;
    }
    drift.point_rate = velocity_a + wander_a;
  } else {
    drift.point_rate = velocity_a + wander_a;
  }
  const Vec3 r_a = point - a.center;
  const Vec3 r_b = point - b.center;
  drift.velocity_rate = a.angular_velocity.cross(a.angular_velocity.cross(r_a) + wander_a) -
                        b.angular_velocity.cross(b.angular_velocity.cross(r_b) + wander_b);
  return drift;
}

}  // namespace rb
