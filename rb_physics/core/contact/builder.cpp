#include "contact/builder.hpp"

#include "math/rotation.hpp"

namespace rb {

void build_body(const std::vector<Body>& bodies, const BodyIndex& index, std::size_t k,
                ContactProblem& out) {
  const Body& body = bodies[index.rows[k]];
  out.inv_mass[k] = body.inertia.inv_mass;
  out.inv_inertia[k] = world_inverse_inertia(body.state.q, body.inertia);
  out.velocity[k] << linear_velocity(body.state, body.inertia) - index.reference,
      angular_velocity(body.state, body.inertia);
}

void build_bodies(const std::vector<Body>& bodies, const BodyIndex& index, ContactProblem& out) {
  const std::size_t n = index.rows.size();
  out.inv_mass.resize(n);
  out.inv_inertia.resize(n);
  out.velocity.resize(n);
  for (std::size_t k = 0; k < n; ++k) build_body(bodies, index, k, out);
  out.contacts.clear();
}

void set_constraint(const std::vector<Body>& bodies, const BodyIndex& index, const Contact& contact,
                    const ContactPlace& place, ContactConstraint& c) {
  const Body& b = bodies[contact.body_b];
  c.a = (*index.index_of)[contact.body_a];
  c.b = b.is_dynamic() ? (*index.index_of)[contact.body_b] : -1;
  c.r_a = place.point - place.center_a;
  c.r_b = place.point - place.center_b;
  c.frame = contact_frame(place.normal);
  c.bias = c.angular_bias = Vec3::Zero();
  if (b.type == BodyType::KINEMATIC) {
    c.bias = -(c.frame * ((b.velocity - index.reference) + b.spin.cross(c.r_b)));
    c.angular_bias = -(c.frame * b.spin);
  } else if (!b.is_dynamic() && !index.reference.isZero(0.0)) {
    c.bias = c.frame * index.reference;
  }
  c.friction = contact.material.friction;
  c.static_friction = contact.material.static_friction;
  c.rolling_friction = contact.material.rolling_friction;
  c.spinning_friction = contact.material.spinning_friction;
  c.restitution = contact.material.restitution;
}

void build_contact(const std::vector<Body>& bodies, const BodyIndex& index, const Contact& contact,
                   const ContactPlace& place, ContactProblem& out) {
  set_constraint(bodies, index, contact, place, out.contacts.emplace_back());
}

}  // namespace rb
