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

// A rigid motion over [0, t_max]: the centre flies along a parabola, the body turns about it.
// Bounds may be generous (that costs iterations) but never too small (that may miss an impact).
class Sweep {
 public:
  virtual ~Sweep() = default;
  virtual Vec3 center(double t) const = 0;              // m, the point the rotation is about, world
  virtual Vec3 linear_velocity() const = 0;             // m/s, of the centre at t = 0
  virtual Vec3 linear_acceleration() const = 0;         // m/s^2, of the centre, constant
  virtual Pose about_center(double t) const = 0;        // of the body frame, seen from the centre
  virtual double max_angular_speed() const = 0;         // rad/s, bound over the interval
  virtual double max_angular_acceleration() const = 0;  // rad/s^2, bound over the interval
  virtual double resolved_until() const = 0;  // s, beyond it the attitude can't be told any more
  // Bounds for an axis fixed to the body (unit, world, at t = 0): how fast it turns, rad/s, and how
  // fast that changes, rad/s^2. What the body turns about it does not count.
  struct AxisTurn {
    double speed, acceleration;
  };
  virtual AxisTurn axis_turn(const Vec3& axis) const = 0;
  // What working out the pose at t costs, in units of about a microsecond.
  virtual double effort(double t) const = 0;

  Pose at(double t) const {
    const Pose pose = about_center(t);
    return {center(t) + pose.position, pose.orientation};
  }
};

struct ImpactSearch {
  std::optional<double> time;  // s, the contact time; nothing when the shapes don't meet
  int iterations = 0;          // distance queries spent
  // False: the work was capped, or motions went on beyond what can be resolved. `time` is then a
  // time up to which nothing met.
  bool converged = true;
};
void keep_earlier(ImpactSearch& best, const ImpactSearch& other);  // work adds up

// Smallest t in [0, t_max] at which the shapes touch, separation 0 reached from outside (S7: the
// contact time). Shapes that touch or overlap at t = 0: an impact at 0 when they go (deeper) into
// each other, else the next impact after they have parted; resting on each other is no impact.
// Throws std::invalid_argument for two shapes that are half-spaces, meshes or height fields.
// Usually ten to twenty distance queries; thousands for surfaces that roll along each other or
// spin.
inline constexpr int usual_distance_queries = 2000;
ImpactSearch find_time_of_impact(const Shape& a, const Sweep& motion_a, const Shape& b,
                                 const Sweep& motion_b, double t_max,
                                 int most_queries = usual_distance_queries);

inline std::optional<double> time_of_impact(const Shape& a, const Sweep& motion_a, const Shape& b,
                                            const Sweep& motion_b, double t_max) {
  return find_time_of_impact(a, motion_a, b, motion_b, t_max).time;
}

struct RayHit {
  double distance;  // m along the unit direction
  Vec3 point;       // m, world
  Vec3 normal;      // unit, outward
};
// Nearest hit of the ray (direction of any length > 0). A ray that starts inside a solid hits at
// distance 0 with the normal -direction. Meshes and height fields are surfaces, hit from both
// sides; a particle is never hit. Throws std::invalid_argument for a zero direction and numbers
// that are not finite.
std::optional<RayHit> ray_cast(const Shape& shape, const Pose& pose, const Vec3& origin,
                               const Vec3& direction);

}  // namespace rb
