// One function per pair of convex shapes, each in a file of its own name. All append to `out` the
// contact points with separation <= margin (m); normals point from the second shape to the first.
#pragma once

#include "collision/manifold.hpp"
#include "shape/shape.hpp"

namespace rb {

// A particle is a sphere of radius 0.
struct Ball {
  double radius;
  bool is_particle;
};

void contacts_ball_ball(const Ball& a, const Placement& at_a, const Ball& b, const Placement& at_b,
                        double margin, Manifold& out);
void contacts_ball_box(const Ball& a, const Placement& at_a, const Box& b, const Placement& at_b,
                       double margin, Manifold& out);
void contacts_ball_half_space(const Ball& a, const Placement& at_a, const HalfSpace& b,
                              const Placement& at_b, double margin, Manifold& out);
void contacts_box_half_space(const Box& a, const Placement& at_a, const HalfSpace& b,
                             const Placement& at_b, double margin, Manifold& out);
void contacts_box_box(const Box& a, const Placement& at_a, const Box& b, const Placement& at_b,
                      double margin, Manifold& out);

void contacts_ball_hull(const Ball& a, const Placement& at_a, const ConvexHull& b,
                        const Placement& at_b, double margin, Manifold& out);
void contacts_box_hull(const Box& a, const Placement& at_a, const ConvexHull& b,
                       const Placement& at_b, double margin, Manifold& out);
void contacts_hull_hull(const ConvexHull& a, const Placement& at_a, const ConvexHull& b,
                        const Placement& at_b, double margin, Manifold& out);
void contacts_hull_half_space(const ConvexHull& a, const Placement& at_a, const HalfSpace& b,
                              const Placement& at_b, double margin, Manifold& out);

void contacts_ball_capsule(const Ball& a, const Placement& at_a, const Capsule& b,
                           const Placement& at_b, double margin, Manifold& out);
void contacts_capsule_capsule(const Capsule& a, const Placement& at_a, const Capsule& b,
                              const Placement& at_b, double margin, Manifold& out);
void contacts_capsule_cylinder(const Capsule& a, const Placement& at_a, const Cylinder& b,
                               const Placement& at_b, double margin, Manifold& out);
void contacts_capsule_box(const Capsule& a, const Placement& at_a, const Box& b,
                          const Placement& at_b, double margin, Manifold& out);
void contacts_capsule_hull(const Capsule& a, const Placement& at_a, const ConvexHull& b,
                           const Placement& at_b, double margin, Manifold& out);
void contacts_capsule_half_space(const Capsule& a, const Placement& at_a, const HalfSpace& b,
                                 const Placement& at_b, double margin, Manifold& out);
void contacts_ball_cylinder(const Ball& a, const Placement& at_a, const Cylinder& b,
                            const Placement& at_b, double margin, Manifold& out);
void contacts_cylinder_cylinder(const Cylinder& a, const Placement& at_a, const Cylinder& b,
                                const Placement& at_b, double margin, Manifold& out);
void contacts_cylinder_box(const Cylinder& a, const Placement& at_a, const Box& b,
                           const Placement& at_b, double margin, Manifold& out);
void contacts_cylinder_hull(const Cylinder& a, const Placement& at_a, const ConvexHull& b,
                            const Placement& at_b, double margin, Manifold& out);
void contacts_cylinder_half_space(const Cylinder& a, const Placement& at_a, const HalfSpace& b,
                                  const Placement& at_b, double margin, Manifold& out);

}  // namespace rb
