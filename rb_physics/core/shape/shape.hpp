// Every shape of the simulator as plain data, in body coordinates. A Shape is a closed variant, so
// that a pair of shapes dispatches on two indices and copies are cheap (large data is shared).
#pragma once

#include <memory>
#include <variant>
#include <vector>

#include "math/mass_properties.hpp"
#include "math/types.hpp"

namespace rb {

struct Particle {};  // a point mass without rotation (S1)
struct Sphere {
  double radius;
};  // m, centre at the origin
struct Box {
  Vec3 half_extents;
};  // m
struct Capsule {
  double radius;
  double half_length;
};  // m, axis z, half_length of the segment
struct Cylinder {
  double radius;
  double half_length;
};  // m, axis z
struct HalfSpace {
  Vec3 normal;
  double offset;
};  // n . x <= offset is solid; n unit; m

struct HullData;    // shape/hull.hpp
struct MeshData;    // shape/mesh.hpp
struct HeightData;  // shape/height_field.hpp
struct CompoundData;

struct ConvexHull {
  std::shared_ptr<const HullData> data;
};
struct TriangleMesh {
  std::shared_ptr<const MeshData> data;
};  // static bodies only
struct HeightField {
  std::shared_ptr<const HeightData> data;
};  // static bodies only
struct Compound {
  std::shared_ptr<const CompoundData> data;
};

using Shape = std::variant<Particle, Sphere, Box, Capsule, Cylinder, HalfSpace, ConvexHull,
                           TriangleMesh, HeightField, Compound>;

struct CompoundPart {
  Shape shape;
  Pose pose;  // part -> body
};
struct CompoundData {
  std::vector<CompoundPart> parts;  // leaves only: nested compounds are flattened when built
};

const char* shape_name(const Shape& shape);  // as in scene files: "sphere", "half_space", ...

// Density 1 kg/m^3. Throws std::invalid_argument for shapes without volume (particle, half-space,
// open mesh).
MassProperties unit_density_mass(const Shape& shape);

// Tight world box; infinite for half-spaces.
Aabb bounding_box(const Shape& shape, const Pose& pose);

// Radius of the smallest sphere about `center` (body coordinates) that holds the shape, m.
double bounding_radius(const Shape& shape, const Vec3& center);

// Characteristic length, m: the scale tolerances are relative to. 1 for unbounded shapes.
double characteristic_size(const Shape& shape);

// Least distance of two parallel planes that hold the solid, m; of a hull: of two along a face. 0
// for what is no solid (particle, mesh), infinite for what has no other side.
double least_width(const Shape& shape);

}  // namespace rb
