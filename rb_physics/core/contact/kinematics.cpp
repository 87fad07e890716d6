#include "contact/kinematics.hpp"

#include <cmath>
#include <variant>

#include "collision/feature.hpp"
#include "math/rotation.hpp"
#include "shape/hull.hpp"

namespace rb {
namespace {

constexpr double parallel =
    1e-6;  // rad: a normal this close to an axis or its plane counts as there

ContactSurface ball(double radius, const Vec3& n) {
  return {radius * (Mat3::Identity() - n * n.transpose()), Vec3::Zero()};
}

// A line with a radius around it: the sides of capsule and cylinder.
ContactSurface tube(double radius, const Vec3& axis, const Vec3& n) {
  const Vec3 across = axis.cross(n);
  return {radius * across * across.transpose(), axis};
}

struct Surface {
  const Pose& pose;
  std::uint32_t feature;
  const Vec3& n;

  bool is_edge() const { return feature_type(feature) == FeatureType::EDGE; }
  Vec3 axis() const { return pose.rotate(Vec3::UnitZ()); }

  ContactSurface operator()(const Sphere& s) const { return ball(s.radius, n); }
  ContactSurface operator()(const Box&) const {
    if (!is_edge()) return {};
    return {Mat3::Zero(), pose.rotate(Vec3::Unit(feature_index(feature) / 4))};
  }
  ContactSurface operator()(const ConvexHull& s) const {
    if (!is_edge()) return {};
    const HullEdge& e = s.data->edges.at(feature_index(feature));
    return {Mat3::Zero(),
            pose.rotate((s.data->vertices[e.head] - s.data->vertices[e.tail]).normalized())};
  }
  ContactSurface operator()(const Capsule& s) const {
    const bool side = std::abs(n.dot(axis())) <= parallel;
    return side ? tube(s.radius, axis(), n) : ball(s.radius, n);
  }
  ContactSurface operator()(const Cylinder& s) const {
    const Vec3 z = axis();
    if (std::abs(n.dot(z)) <= parallel) return tube(s.radius, z, n);
    // On the rim, a circle: the radius seen along n grows as n nears the axis. On the cap: a face.
    const Vec3 along_rim = z.cross(n);
    const double sine = along_rim.norm();
    if (sine <= parallel) return {};
    return {s.radius / (sine * sine * sine) * along_rim * along_rim.transpose(), Vec3::Zero()};
  }
  template <class Flat>
  ContactSurface operator()(const Flat&) const {
    return {};
  }
};

// N' in the tangent plane spanned by rows 1 and 2 of `frame`.
Vec3 normal_rate_of_curves(const Mat3& frame, double d, const Vec3& slip, const ContactSurface& sa,
                           const Vec3& turn_a, const ContactSurface& sb, const Vec3& turn_b) {
  const auto tangent = frame.bottomRows<2>();
  // Straight lines bind N' along them.
  Vec2 line_a = tangent * sa.line, line_b = tangent * sb.line;
  const double cross = line_a.x() * line_b.y() - line_a.y() * line_b.x();
  const double rhs_a = sa.line.dot(turn_a), rhs_b = sb.line.dot(turn_b);
  if (std::abs(cross) > parallel) {
    const Vec2 y((rhs_a * line_b.y() - rhs_b * line_a.y()) / cross,
                 (line_a.x() * rhs_b - line_b.x() * rhs_a) / cross);
    return tangent.transpose() * y;
  }
  const Mat3 w = sa.radii + sb.radii;
  const Eigen::Matrix2d stiffness =
      tangent * w * tangent.transpose() + d * Eigen::Matrix2d::Identity();
  const Vec2 drive = tangent * (slip + sa.radii * turn_a + sb.radii * turn_b);
  const bool bound_by_a = line_a.squaredNorm() > 0.25, bound_by_b = line_b.squaredNorm() > 0.25;
  if (bound_by_a || bound_by_b) {
    Vec2 e = bound_by_a ? line_a : line_b;
    double rate = bound_by_a ? rhs_a : rhs_b;
    if (bound_by_a && bound_by_b) {  // parallel: the mean of both
      const double same_way = line_a.dot(line_b) < 0.0 ? -1.0 : 1.0;
      e = 0.5 * (line_a + same_way * line_b);
      rate = 0.5 * (rhs_a + same_way * rhs_b);
    }
    const Vec2 across(-e.y(), e.x());
    const double stiff = across.dot(stiffness * across);
    const double free = stiff > 0.0 ? across.dot(drive - rate * (stiffness * e)) / stiff : 0.0;
    return tangent.transpose() * (rate * e + free * across);
  }
  const double determinant = stiffness.determinant();
  if (!(determinant > 0.0)) return 0.5 * (turn_a + turn_b);  // two points that coincide: no normal
  return tangent.transpose() * (stiffness.inverse() * drive);
}

}  // namespace

ContactSurface contact_surface(const Shape& shape, const Pose& pose, std::uint32_t feature,
                               const Vec3& outward) {
  return std::visit(Surface{pose, feature, outward}, shape);
}

ContactKinematics contact_kinematics(const ContactPoint& contact, const ContactSurface& surface_a,
                                     const BodyMotion& a, const ContactSurface& surface_b,
                                     const BodyMotion& b) {
  const Vec3& n = contact.normal;
  const Vec3 gap = contact.point_a - contact.point_b;
  const Vec3 velocity = a.point_velocity(contact.point_a) - b.point_velocity(contact.point_b);
  const Vec3 acceleration =
      a.point_acceleration(contact.point_a) - b.point_acceleration(contact.point_b);
  const Vec3 turn_a = a.angular_velocity.cross(n);
  const Vec3 turn_b = b.angular_velocity.cross(n);

  ContactKinematics k;
  k.d = n.dot(gap);
  double normal_acceleration;  // N'' . (P_A - P_B)
  if (contact.normal_owner == NormalOwner::A || contact.normal_owner == NormalOwner::B) {
    const BodyMotion& owner = contact.normal_owner == NormalOwner::A ? a : b;
    k.normal_rate = contact.normal_owner == NormalOwner::A ? turn_a : turn_b;
    normal_acceleration =
        gap.dot(owner.angular_acceleration.cross(n) + owner.angular_velocity.cross(k.normal_rate));
  } else {
    const Mat3 frame = contact_frame(n);
    k.normal_rate =
        normal_rate_of_curves(frame, k.d, velocity, surface_a, turn_a, surface_b, turn_b);
    normal_acceleration = -k.d * k.normal_rate.squaredNorm();
  }
  k.d_dot = n.dot(velocity) + k.normal_rate.dot(gap);
  const Vec3 wander_a = k.normal_rate - turn_a;
  const Vec3 wander_b = k.normal_rate - turn_b;
  k.d_ddot = n.dot(acceleration) + 2.0 * k.normal_rate.dot(velocity) + normal_acceleration -
             wander_a.dot(surface_a.radii * wander_a) - wander_b.dot(surface_b.radii * wander_b);
  return k;
}

}  // namespace rb
