// The shape classes of the Python interface: immutable, checked when made, picklable.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>
#include <string>
#include <vector>

#include "bindings/arguments.hpp"
#include "shape/compound.hpp"
#include "shape/hull.hpp"
#include "shape/shape.hpp"

namespace py = pybind11;

namespace rb {

namespace {

using bindings::checked_length;
using bindings::checked_orientation;
using bindings::checked_vector;
using bindings::refuse;

std::string call(const char* name,
                 const std::vector<std::pair<const char*, py::object>>& arguments) {
  std::string text = std::string(name) + "(";
  for (const auto& [field, value] : arguments) {
    if (text.back() != '(') text += ", ";
    text += std::string(field) + "=" + std::string(py::repr(value));
  }
  return text + ")";
}

py::object tuple_of(const Vec3& v) { return py::make_tuple(v.x(), v.y(), v.z()); }

py::object tuple_of(const Quat& q) { return py::make_tuple(q.x(), q.y(), q.z(), q.w()); }

double length_argument(const std::string& field, const py::object& value) {
  return checked_length(field, bindings::number(field, value, "a length between 1e-9 and 1e9 m"));
}

Sphere make_sphere(const py::object& radius) { return {length_argument("shape.radius", radius)}; }

Box make_box(const py::object& value) {
  const Vec3 half_extents = bindings::vector3("shape.half_extents", value);
  for (const double h : half_extents) {
    if (!(h >= bindings::least_length && h <= bindings::greatest_length)) {
      refuse("shape.half_extents", bindings::as_list(half_extents),
             "three lengths between 1e-9 and 1e9 m");
    }
  }
  return {half_extents};
}

Capsule make_capsule(const py::object& radius, const py::object& half_length) {
  return {length_argument("shape.radius", radius),
          length_argument("shape.half_length", half_length)};
}

Cylinder make_cylinder(const py::object& radius, const py::object& half_length) {
  return {length_argument("shape.radius", radius),
          length_argument("shape.half_length", half_length)};
}

HalfSpace make_half_space(const py::object& value, const py::object& distance) {
  const std::string finite = "a finite number of at most 1e9 (m)";
  const double offset = bindings::number("shape.offset", distance, finite);
  const Vec3 normal = bindings::vector3("shape.normal", value);
  const double length = normal.norm();
  if (!(std::abs(length - 1.0) <= tolerance::quaternion_norm)) {
    refuse("shape.normal", bindings::as_list(normal), "a unit vector (its length must be 1)");
  }
  if (!(std::abs(offset) <= bindings::greatest_length)) {
    refuse("shape.offset", distance, finite);
  }
  return {std::abs(length - 1.0) <= 4e-16 ? normal : Vec3(normal / length), offset};
}

ConvexHull make_hull_of(const py::object& value) {
  const std::optional<InputArray> given = bindings::real_numbers(value);
  if (!given || given->ndim() != 2 || given->shape(1) != 3) {
    refuse("shape.points", value, "numbers in an array of shape (n, 3) (m)");
  }
  const InputArray& rows = *given;
  std::vector<Vec3> points;
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    points.push_back(checked_vector("shape.points[" + std::to_string(i) + "]",
                                    {rows.at(i, 0), rows.at(i, 1), rows.at(i, 2)}));
  }
  try {
    return make_hull(points);
  } catch (const std::invalid_argument& error) {
    bindings::refuse_because("shape.points", error.what());
  }
}

py::array_t<double> hull_points(const ConvexHull& hull) {
  const auto& vertices = hull.data->vertices;
  py::array_t<double> out({static_cast<py::ssize_t>(vertices.size()), py::ssize_t{3}});
  auto view = out.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < view.shape(0); ++i) {
    for (int k = 0; k < 3; ++k) view(i, k) = vertices[i][k];
  }
  return out;
}

std::vector<std::vector<int>> hull_faces(const ConvexHull& hull) {
  std::vector<std::vector<int>> faces;
  for (const HullFace& face : hull.data->faces) {
    const auto first = hull.data->face_vertices.begin() + face.first;
    faces.emplace_back(first, first + face.count);
  }
  return faces;
}

py::array_t<int> hull_edges(const ConvexHull& hull) {
  const auto& edges = hull.data->edges;
  py::array_t<int> out({static_cast<py::ssize_t>(edges.size()), py::ssize_t{2}});
  auto view = out.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < view.shape(0); ++i) {
    view(i, 0) = edges[i].tail;
    view(i, 1) = edges[i].head;
  }
  return out;
}

// A list or tuple; text, arrays and what can only be gone through once are none.
bool is_list(const py::object& value) {
  return py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value);
}

CompoundPart make_part(const std::string& field, const py::object& value) {
  const auto items = is_list(value) ? py::sequence(value) : py::sequence(py::tuple());
  if (items.size() != 3) refuse(field, value, "(shape, position, orientation)");
  py::detail::make_caster<Shape> shape;
  if (!shape.load(items[0], false)) refuse(field + ".shape", items[0], "a shape");
  return {py::detail::cast_op<Shape>(shape),
          {checked_vector(field + ".position", bindings::vector3(field + ".position", items[1])),
           checked_orientation(field + ".orientation",
                               bindings::vector4(field + ".orientation", items[2]))}};
}

Compound make_compound_of(const py::object& value) {
  if (!is_list(value)) refuse("shape.parts", value, "a list of (shape, position, orientation)");
  const py::sequence placed = value;
  std::vector<CompoundPart> parts;
  for (std::size_t i = 0; i < placed.size(); ++i)
    parts.push_back(make_part("shape.parts[" + std::to_string(i) + "]", placed[i]));
  try {
    return make_compound(parts);
  } catch (const std::invalid_argument& error) {
    bindings::refuse_because("shape.parts", error.what());
  }
}

py::list parts_of(const Compound& compound) {
  py::list parts;
  for (const CompoundPart& part : compound.data->parts) {
    parts.append(py::make_tuple(py::cast(part.shape), tuple_of(part.pose.position),
                                tuple_of(part.pose.orientation)));
  }
  return parts;
}

// Equality, hash, repr and pickling follow from the tuple of constructor arguments.
template <class T, class Fields>
void complete(py::class_<T>& type, const char* name, std::vector<const char*> names,
              Fields fields) {
  type.def("__repr__",
           [name, names, fields](const T& self) {
             const py::tuple values = fields(self);
             std::vector<std::pair<const char*, py::object>> arguments;
             for (std::size_t i = 0; i < names.size(); ++i) {
               arguments.emplace_back(names[i], py::object(values[i]));
             }
             return call(name, arguments);
           })
      .def("__eq__",
           [fields](const T& self, const py::object& other) -> py::object {
             if (!py::isinstance<T>(other))
               return py::reinterpret_borrow<py::object>(Py_NotImplemented);
             return py::bool_(fields(self).equal(fields(other.cast<const T&>())));
           })
      .def("__hash__",
           [name, fields](const T& self) { return py::hash(py::make_tuple(name, fields(self))); })
      .def("__reduce__", [fields](const py::object& self) {
        return py::make_tuple(py::type::of(self), fields(self.cast<const T&>()));
      });
}

}  // namespace

void define_shapes(py::module_& m) {
  py::class_<Particle> particle(m, "Particle", "A point mass: no extent, no rotation.");
  particle.def(py::init<>());
  complete(particle, "Particle", {}, [](const Particle&) { return py::tuple(); });

  py::class_<Sphere> sphere(m, "Sphere", "Ball of `radius` (m) about the body's origin.");
  sphere.def(py::init(&make_sphere), py::arg("radius")).def_readonly("radius", &Sphere::radius);
  complete(sphere, "Sphere", {"radius"}, [](const Sphere& s) { return py::make_tuple(s.radius); });

  py::class_<Box> box(m, "Box", "Cuboid about the body's origin; `half_extents` (3,), m.");
  box.def(py::init(&make_box), py::arg("half_extents"))
      .def_property_readonly("half_extents", [](const Box& s) { return tuple_of(s.half_extents); });
  complete(box, "Box", {"half_extents"},
           [](const Box& s) { return py::make_tuple(tuple_of(s.half_extents)); });

  py::class_<Capsule> capsule(m, "Capsule",
                              "All points within `radius` (m) of the segment from -half_length to "
                              "+half_length (m) on the body's z axis.");
  capsule.def(py::init(&make_capsule), py::arg("radius"), py::arg("half_length"))
      .def_readonly("radius", &Capsule::radius)
      .def_readonly("half_length", &Capsule::half_length);
  complete(capsule, "Capsule", {"radius", "half_length"},
           [](const Capsule& s) { return py::make_tuple(s.radius, s.half_length); });

  py::class_<Cylinder> cylinder(
      m, "Cylinder",
      "Solid cylinder about the body's z axis, from -half_length to +half_length (m).");
  cylinder.def(py::init(&make_cylinder), py::arg("radius"), py::arg("half_length"))
      .def_readonly("radius", &Cylinder::radius)
      .def_readonly("half_length", &Cylinder::half_length);
  complete(cylinder, "Cylinder", {"radius", "half_length"},
           [](const Cylinder& s) { return py::make_tuple(s.radius, s.half_length); });

  py::class_<HalfSpace> half_space(
      m, "HalfSpace", "Solid where normal . x <= offset (m); `normal` is a unit vector, outward.");
  half_space
      .def(py::init(&make_half_space), py::arg("normal") = py::make_tuple(0.0, 0.0, 1.0),
           py::arg("offset") = 0.0)
      .def_property_readonly("normal", [](const HalfSpace& s) { return tuple_of(s.normal); })
      .def_readonly("offset", &HalfSpace::offset);
  complete(half_space, "HalfSpace", {"normal", "offset"},
           [](const HalfSpace& s) { return py::make_tuple(tuple_of(s.normal), s.offset); });

  py::class_<ConvexHull> hull(
      m, "ConvexHull",
      "Convex hull of `points` (n, 3), m, in body coordinates; inner points are dropped, and "
      "those nearer to an earlier one than 1e-8 of the extent. Raises SceneError for points that "
      "span no volume.");
  hull.def(py::init(&make_hull_of), py::arg("points"))
      .def_property_readonly("points", &hull_points, "Corners (n, 3), m, in the order given.")
      .def_property_readonly("faces", &hull_faces,
                             "Corner indices of each flat face, counterclockwise from outside.")
      .def_property_readonly("edges", &hull_edges, "Corner indices (n, 2) of the edges.");
  complete(hull, "ConvexHull", {"points"}, [](const ConvexHull& s) {
    py::list rows;
    for (const Vec3& v : s.data->vertices) rows.append(tuple_of(v));
    return py::make_tuple(py::tuple(rows));
  });

  py::class_<Compound> compound(
      m, "Compound",
      "Several solid shapes as one body: `parts` is a list of (shape, position (3,) m, orientation "
      "(x, y, z, w)), placed in body coordinates. Nested compounds are flattened.");
  compound.def(py::init(&make_compound_of), py::arg("parts"))
      .def_property_readonly("parts", &parts_of);
  complete(compound, "Compound", {"parts"},
           [](const Compound& s) { return py::make_tuple(py::tuple(parts_of(s))); });
}

}  // namespace rb
