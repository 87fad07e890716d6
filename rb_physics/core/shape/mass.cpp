// Volume, centre of mass and inertia of every solid shape at density 1 kg/m^3, in closed form.
#include <numbers>
#include <stdexcept>
#include <string>

#include "shape/hull.hpp"
#include "shape/mesh.hpp"
#include "shape/shape.hpp"

namespace rb {

namespace {

constexpr double pi = std::numbers::pi;

MassProperties centred(double mass, const Vec3& moments) {
  return {mass, Vec3::Zero(), moments.asDiagonal()};
}

MassProperties without_volume(const char* name) {
  throw std::invalid_argument(std::string("shape ") + name +
                              " has no volume: give mass and inertia instead of density");
}

struct UnitDensityMass {
  MassProperties operator()(const Particle&) const { return without_volume("particle"); }
  MassProperties operator()(const HalfSpace&) const { return without_volume("half_space"); }
  MassProperties operator()(const TriangleMesh& s) const {
    return s.data->closed && s.data->volume > 0.0 ? s.data->mass
                                                  : without_volume("triangle_mesh (it is open)");
  }
  MassProperties operator()(const HeightField&) const { return without_volume("height_field"); }

  MassProperties operator()(const Sphere& s) const {
    const double r = s.radius;
    const double mass = 4.0 / 3.0 * pi * r * r * r;
    return centred(mass, Vec3::Constant(0.4 * mass * r * r));
  }
  MassProperties operator()(const Box& s) const {
    const Vec3 h = s.half_extents;
    const double mass = 8.0 * h.x() * h.y() * h.z();
    const Vec3 sq = h.cwiseProduct(h);
    return centred(mass, mass / 3.0 * Vec3(sq.y() + sq.z(), sq.x() + sq.z(), sq.x() + sq.y()));
  }
  MassProperties operator()(const Cylinder& s) const {
    const double r = s.radius, h = s.half_length;
    const double mass = 2.0 * pi * r * r * h;
    const double across = mass * (0.25 * r * r + h * h / 3.0);
    return centred(mass, Vec3(across, across, 0.5 * mass * r * r));
  }
  MassProperties operator()(const Capsule& s) const {
    // A cylinder and two half balls, whose centres of mass lie 3r/8 beyond its caps.
    const double r = s.radius, h = s.half_length;
    const double middle = 2.0 * pi * r * r * h;
    const double ball = 4.0 / 3.0 * pi * r * r * r;
    const double across =
        middle * (0.25 * r * r + h * h / 3.0) + ball * (0.4 * r * r + h * h + 0.75 * h * r);
    return centred(middle + ball, Vec3(across, across, 0.5 * middle * r * r + 0.4 * ball * r * r));
  }
  MassProperties operator()(const ConvexHull& s) const { return s.data->mass; }
  MassProperties operator()(const Compound& s) const {
    // Parts are taken as disjoint: where they overlap, matter counts twice.
    MassProperties total;
    for (const CompoundPart& part : s.data->parts) {
      const MassProperties own = transformed(unit_density_mass(part.shape), part.pose);
      total = total.mass > 0.0 ? combined(total, own) : own;
    }
    return total;
  }
};

}  // namespace

MassProperties unit_density_mass(const Shape& shape) {
  return std::visit(UnitDensityMass{}, shape);
}

}  // namespace rb
