#include "collision/moving_pair.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "collision/extent.hpp"

namespace rb {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double infinity = std::numeric_limits<double>::infinity();

// What turning does to the points of a shape: bounds.
struct Turning {
  double speed;      // m/s, about the centre
  double curvature;  // m/s^2, of their paths
  double arm;        // m, radius of what turns
};

// A ball turns only by its own centre, a shape of revolution only by its axis: what turns about
// that does not count.
Turning turning_of(const Shape& shape, const Sweep& motion) {
  const double w = motion.max_angular_speed();
  const double bend = w * w + motion.max_angular_acceleration();
  const Pose pose = motion.about_center(0.0);
  const Vec3 center = pose.apply_inverse(Vec3::Zero());
  const auto all = [&](double radius) { return Turning{w * radius, bend * radius, radius}; };
  if (std::holds_alternative<Sphere>(shape)) return all(center.norm());
  double radius = 0.0;
  const Vec3 on_axis(0.0, 0.0, center.z());
  if (const auto* s = std::get_if<Capsule>(&shape)) {
    radius = bounding_radius(Capsule{0.0, s->half_length}, on_axis);
  } else if (std::holds_alternative<Cylinder>(shape)) {
    radius = bounding_radius(shape, on_axis);
  } else {
    return all(bounding_radius(shape, center));
  }
  const Sweep::AxisTurn axis = motion.axis_turn(pose.rotate(Vec3::UnitZ()));
  const Turning foot = all((center - on_axis).norm());
  return {foot.speed + axis.speed * radius,
          foot.curvature + (axis.speed * axis.speed + axis.acceleration) * radius,
          foot.arm + radius};
}

// What does not turn may be seen from any centre: from its middle it is smallest.
Vec3 middle(const Shape& shape, const Sweep& motion) {
  if (motion.max_angular_speed() > 0.0 || motion.max_angular_acceleration() > 0.0) {
    return Vec3::Zero();
  }
  const Aabb box = bounding_box(shape, motion.about_center(0.0));
  return 0.5 * (box.lower + box.upper);
}

// First s > 0 at which f + v s + a s^2 / 2 is 0, from f > 0 on; infinity when there is none.
double first_root(double f, double v, double a) {
  if (a >= 0.0 && v >= 0.0) return infinity;
  const double discriminant = v * v - 2.0 * a * f;
  if (discriminant < 0.0) return infinity;
  const double root = std::sqrt(discriminant);
  return v > 0.0 ? (v + root) / -a : 2.0 * f / (root - v);  // the form that loses no digits
}

}  // namespace

MovingPair::MovingPair(const Shape& a, const Sweep& motion_a, const Shape& b, const Sweep& motion_b,
                       double t_max)
    : a_(a), b_(b), motion_a_(motion_a), motion_b_(motion_b), t_max_(t_max) {
  if (std::holds_alternative<HalfSpace>(a)) plane_ = Plane::A;
  if (std::holds_alternative<HalfSpace>(b)) {
    if (plane_ == Plane::A) {
      throw std::invalid_argument("time_of_impact: two half-spaces have no contact time");
    }
    plane_ = Plane::B;
  }
  velocity_ = motion_a.linear_velocity() - motion_b.linear_velocity();
  acceleration_ = motion_a.linear_acceleration() - motion_b.linear_acceleration();
  const Vec3 center_a = motion_a.center(0.0), center_b = motion_b.center(0.0);
  const double wa = motion_a.max_angular_speed(), wb = motion_b.max_angular_speed();
  Turning turning_a{0.0, 0.0, 0.0}, turning_b{0.0, 0.0, 0.0};
  const auto measure = [&](const Shape& shape, const Sweep& motion, Vec3& from_center,
                           double& radius, Turning& turning) {
    from_center = middle(shape, motion);
    radius = bounding_radius(shape, motion.about_center(0.0).apply_inverse(from_center));
    if (motion.max_angular_speed() > 0.0 || motion.max_angular_acceleration() > 0.0) {
      turning = turning_of(shape, motion);
    }
  };
  if (plane_ != Plane::A) measure(a, motion_a, middle_a_, radius_a_, turning_a);
  if (plane_ != Plane::B) measure(b, motion_b, middle_b_, radius_b_, turning_b);
  start_ = (center_a - center_b) + (middle_a_ - middle_b_);
  if (plane_ != Plane::NONE) {
    const auto& plane = std::get<HalfSpace>(plane_ == Plane::A ? a : b);
    const Pose pose = (plane_ == Plane::A ? motion_a : motion_b).about_center(0.0);
    plane_reach_ = std::abs(plane.offset) + pose.position.norm();
  }
  size_ = plane_ == Plane::A   ? radius_b_
          : plane_ == Plane::B ? radius_a_
                               : std::min(radius_a_, radius_b_);
  scale_ = center_a.norm() + center_b.norm() + middle_a_.norm() + middle_b_.norm() + radius_a_ +
           radius_b_ + plane_reach_;
  // Two positions as far from each other as this can't be told apart by the smaller shape's size.
  const double lost = (size_ > 0.0 ? size_ : 1.0) / (4.0 * epsilon) - scale_;
  const double v = velocity_.norm(), acc = acceleration_.norm();
  const double told = lost > 0.0 ? 2.0 * lost / (v + std::sqrt(v * v + 2.0 * acc * lost)) : 0.0;
  horizon_ = std::min(t_max, told);
  for (const Sweep* motion : {&motion_a, &motion_b}) {
    if (motion->max_angular_speed() > 0.0) {
      horizon_ = std::min(horizon_, motion->resolved_until());
    }
  }
  const double fastest = std::max(velocity_.norm(), velocity(horizon_).norm());
  // A turning plane moves fastest where the other shape may be.
  const double reach = start_.norm() + horizon_ * fastest + size_;
  const auto turn_plane = [&](const Sweep& motion, Turning& turning) {
    const double w = motion.max_angular_speed();
    if (w > 0.0) {
      turning = {w * reach, (w * w + motion.max_angular_acceleration()) * reach, reach};
    }
  };
  if (plane_ == Plane::A) turn_plane(motion_a, turning_a);
  if (plane_ == Plane::B) turn_plane(motion_b, turning_b);
  turning_a_ = turning_a.speed;
  turning_b_ = turning_b.speed;
  turning_speed_ = turning_a_ + turning_b_;
  angular_speed_ = wa + wb;
  arms_ = turning_a.arm + turning_b.arm;
  turning_curvature_ = turning_a.curvature + turning_b.curvature;
  const double plane_rate = plane_ == Plane::A ? wa : plane_ == Plane::B ? wb : 0.0;
  if (plane_rate > 0.0) {  // the axis turns too: d/dt^2 (m . x) has a Coriolis term
    turning_curvature_ +=
        2.0 * plane_rate * (fastest + (plane_ == Plane::A ? turning_b_ : turning_a_));
  }
}

double MovingPair::rounding(double t) const {
  return 4.0 * epsilon * (scale_ + t * (velocity_.norm() + 0.5 * t * acceleration_.norm()));
}

double MovingPair::effort(double t) const {
  return 1.0 + motion_a_.effort(t) + motion_b_.effort(t);
}

Pose MovingPair::pose_a(double t) const {
  const Pose pose = motion_a_.about_center(t);
  return {apart(t) + (pose.position - middle_a_), pose.orientation};
}

Pose MovingPair::pose_b(double t) const {
  const Pose pose = motion_b_.about_center(t);
  return {pose.position - middle_b_, pose.orientation};
}

DistanceResult MovingPair::distance_at(double t) const {
  return distance(a_, pose_a(t), b_, pose_b(t));
}

double MovingPair::gap_along(const Vec3& n, double t) const {
  const Pose at_a = pose_a(t), at_b = pose_b(t);
  const auto above = [](const Shape& half_space, const Pose& at, const Shape& other,
                        const Pose& pose) {
    const auto& plane = std::get<HalfSpace>(half_space);
    const Vec3 normal = at.rotate(plane.normal);
    return -extent(other, pose, -normal) - (plane.offset + normal.dot(at.position));
  };
  if (plane_ == Plane::B) return above(b_, at_b, a_, at_a);
  if (plane_ == Plane::A) return above(a_, at_a, b_, at_b);
  return -extent(a_, at_a, -n) - extent(b_, at_b, n);
}

double MovingPair::curvature(const Vec3& n) const {
  // The normal of a plane that turns is not the axis it had.
  const bool turns = plane_ != Plane::NONE &&
                     (plane_ == Plane::A ? motion_a_ : motion_b_).max_angular_speed() > 0.0;
  return (turns ? acceleration_.norm() : n.dot(acceleration_)) + turning_curvature_;
}

double MovingPair::speed(double t, double h) const {
  return std::max(velocity(t).norm(), velocity(t + h).norm()) + turning_speed_;
}

double MovingPair::curvature(double rate, double t, double h) const {
  const double fastest = speed(t, h);
  const double distance = apart(t).norm() + h * fastest + arms_;
  return max_curvature() + 2.0 * rate * fastest + rate * rate * distance;
}

double MovingPair::useful_chord() const {
  return turning_curvature_ > 0.0 ? 8.0 * std::sqrt(arms_ / turning_curvature_) : infinity;
}

double MovingPair::time_to_cover(double gap, double t) const {
  const double v = velocity(t).norm() + turning_speed_;
  const double root = v + std::sqrt(v * v + 2.0 * acceleration_.norm() * gap);
  return root > 0.0 ? 2.0 * gap / root : infinity;
}

double MovingPair::apart_until(double t) const {
  constexpr int most_rounds = 64;
  constexpr double near = 1e-3;  // of the radii: the rest is for the true shapes
  Vec3 normal = Vec3::Zero();
  double offset = 0.0;
  if (plane_ != Plane::NONE) {
    if ((plane_ == Plane::A ? motion_a_ : motion_b_).max_angular_speed() > 0.0) return t;
    const Pose at = plane_ == Plane::A ? motion_a_.about_center(0.0) : motion_b_.about_center(0.0);
    const auto& plane = std::get<HalfSpace>(plane_ == Plane::A ? a_ : b_);
    normal = at.rotate(plane.normal);
    offset = plane.offset + normal.dot(at.position);
    if (plane_ == Plane::A) normal = -normal;  // from B to A
  }
  const double radii = (1.0 + 1e-12) * (radius_a_ + radius_b_);
  for (int round = 0; round < most_rounds && t < horizon_; ++round) {
    const Vec3 x = apart(t);
    const double away = x.norm();
    if (plane_ == Plane::NONE) {
      if (!(away > radii)) break;
      normal = x / away;
    }
    const double gap = normal.dot(x) - radii - offset - rounding(t);
    if (!(gap > near * radii) || !(gap > 0.0)) break;
    // The axis stays, the balls do not turn: their gap along it is a parabola.
    const double step = first_root(gap, normal.dot(velocity(t)), normal.dot(acceleration_));
    if (!(step < t_max_ - t)) return t_max_;
    if (!(t + step > t)) break;
    t += step;
  }
  return t;
}

std::optional<MovingPair::Ball> MovingPair::ball() const {
  constexpr double worth_it = 1.0;  // rad
  if (plane_ != Plane::NONE) return std::nullopt;
  const bool of_a = turning_a_ >= turning_b_;
  const double turn = (of_a ? motion_a_ : motion_b_).max_angular_speed() * t_max_;
  if (!((of_a ? turning_a_ : turning_b_) > 0.0) || !(turn > worth_it)) return std::nullopt;
  return Ball{of_a, of_a ? radius_a_ : radius_b_};
}

double certified_step(double f0, double f1, double h, double curvature) {
  const double half = 0.5 * curvature;
  const double slope = (f1 - f0) / h - half * h;  // of half s^2 + slope s + f0
  const double discriminant = slope * slope - 4.0 * half * f0;
  const bool stays = half >= 0.0 ? slope >= 0.0 || discriminant < 0.0 : f1 > 0.0;
  if (stays) return f1 > 0.0 ? h : h * f0 / (f0 - f1);
  const double root = std::sqrt(discriminant);  // the form that loses no digits:
  return std::min(h, slope > 0.0 ? (slope + root) / -curvature : 2.0 * f0 / (root - slope));
}

}  // namespace rb
