// The queries of S7 on two placed shapes. Test-intersection answers yes or no; find-intersection
// gives the contact set; time_of_impact finds the contact time of two moving bodies.
// Nothing in here knows a velocity of the simulation: a moving body is a Sweep, a curve of poses.
#pragma once

#include <optional>

#include "collision/contact_point.hpp"
#include "math/types.hpp"
#include "shape/shape.hpp"

namespace rb {

// True when the closed shapes share a point.
bool test_intersection(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b);

// Appends the contact points with separation <= margin (m) to `out`; normal from b to a.
void find_contacts(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                   double margin, ContactPoints& out);

struct DistanceResult {
  double distance;  // m, negative when overlapping (minus the penetration depth)
  Vec3 point_a;     // m, world
  Vec3 point_b;     // m, world
  Vec3 normal;      // unit, from b to a
};
DistanceResult distance(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b);

// A rigid motion over [0, t_max]: pose of the body frame at t, and bounds that hold on the
// interval.
class Sweep {
 public:
  virtual ~Sweep() = default;
  virtual Pose at(double t) const = 0;
  virtual Vec3 center(double t) const = 0;              // m, the point the rotation is about, world
  virtual double max_angular_speed() const = 0;         // rad/s, bound over the interval
  virtual double max_linear_speed(double t) const = 0;  // m/s, bound for the centre on [t, t_max]
};

// Smallest t in [0, t_max] at which the shapes touch (separation 0 reached from outside; touching
// and separating at t = 0 does not count), or nothing.
std::optional<double> time_of_impact(const Shape& a, const Sweep& motion_a, const Shape& b,
                                     const Sweep& motion_b, double t_max);

struct RayHit {
  double distance;  // m along the unit direction
  Vec3 point;       // m, world
  Vec3 normal;      // unit, outward
};
std::optional<RayHit> ray_cast(const Shape& shape, const Pose& pose, const Vec3& origin,
                               const Vec3& direction);

}  // namespace rb
