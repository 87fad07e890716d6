#include "world/kinematic.hpp"

namespace rb {
namespace {

void turn(Body& body, double t) {
  body.state.x += t * body.velocity;
  if (!body.spin.isZero(0.0)) {
    body.state.q = normalized(quaternion_from_rotation_vector(t * body.spin) * body.state.q);
  }
}

}  // namespace

Pose kinematic_pose(const Body& body, double t) {
  if (body.type == BodyType::STATIC || t == 0.0) return body.pose();
  Vec3 x = body.state.x + t * body.velocity;
  Quat q = body.state.q;
  if (!body.spin.isZero(0.0)) q = normalized(quaternion_from_rotation_vector(t * body.spin) * q);
  return {x - q * body.center_of_mass, q};
}

void aim_at_target(Body& body, double h) {
  if (!body.target || !body.stop_after_target) return;
  const Vec3 x = body.target->apply(body.center_of_mass);
  body.velocity = (x - body.state.x) / h;
  body.spin = rotation_vector(body.target->orientation * body.state.q.conjugate()) / h;
}

void move_kinematic(Body& body, double h) {
  if (!body.target) {
    turn(body, h);
    return;
  }
  body.set_pose(*body.target);
  body.target.reset();
  if (body.stop_after_target) body.velocity = body.spin = Vec3::Zero();
}

}  // namespace rb
