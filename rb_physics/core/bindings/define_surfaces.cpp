// Triangle meshes and height fields: the static surfaces of the Python interface.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <stdexcept>

#include "bindings/arguments.hpp"
#include "shape/height_field.hpp"
#include "shape/mesh.hpp"

namespace py = pybind11;

namespace rb {
namespace {

using Reals = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Integers = py::array_t<std::int64_t, py::array::c_style>;

TriangleMesh make_mesh_of(const py::object& value, const py::object& triangles) {
  using bindings::refuse;
  const std::optional<InputArray> corner_points = bindings::real_numbers(value);
  if (!corner_points || corner_points->ndim() != 2 || corner_points->shape(1) != 3) {
    refuse("shape.vertices", value, "numbers in an array of shape (n, 3) (m)");
  }
  const InputArray& vertices = *corner_points;
  const py::array given = py::array::ensure(triangles);
  const bool integral = given && (given.dtype().kind() == 'i' || given.dtype().kind() == 'u');
  if (!integral || given.ndim() != 2 || given.shape(1) != 3) {
    refuse("shape.triangles", triangles, "an array of integers of shape (m, 3)");
  }
  const Integers indices = Integers::ensure(given.attr("astype")("int64"));
  std::vector<Vec3> points;
  for (py::ssize_t i = 0; i < vertices.shape(0); ++i) {
    points.emplace_back(vertices.at(i, 0), vertices.at(i, 1), vertices.at(i, 2));
  }
  std::vector<std::array<std::int32_t, 3>> corners(indices.shape(0));
  for (py::ssize_t i = 0; i < indices.shape(0); ++i) {
    for (int k = 0; k < 3; ++k) {
      const std::int64_t v = indices.at(i, k);
      if (v < 0 || v >= vertices.shape(0)) {
        refuse("shape.triangles[" + std::to_string(i) + "]", py::cast(v),
               "an index of a vertex, 0 to " + std::to_string(vertices.shape(0) - 1));
      }
      corners[i][k] = static_cast<std::int32_t>(v);
    }
  }
  try {
    return make_triangle_mesh(points, corners);
  } catch (const std::invalid_argument& error) {
    bindings::refuse_because("shape", error.what());
  }
}

Vec2 spacing_argument(const py::object& value) {
  const std::optional<InputArray> given = bindings::real_numbers(value);
  if (given && given->ndim() == 0) return Vec2::Constant(*given->data());
  if (given && given->ndim() == 1 && given->size() == 2)
    return Vec2(given->data()[0], given->data()[1]);
  bindings::refuse("shape.spacing", value, "a length (m) or two, along x and y");
}

HeightField make_field_of(const py::object& value, const py::object& spacing) {
  const std::optional<InputArray> grid = bindings::real_numbers(value);
  if (!grid || grid->ndim() != 2)
    bindings::refuse("shape.heights", value, "numbers in an array of shape (n, m) (m)");
  const InputArray& heights = *grid;
  const Vec2 step = spacing_argument(spacing);
  const std::vector<double> values(heights.data(), heights.data() + heights.size());
  try {
    return make_height_field(static_cast<int>(heights.shape(0)), static_cast<int>(heights.shape(1)),
                             values, step);
  } catch (const std::invalid_argument& error) {
    bindings::refuse_because("shape", error.what());
  }
}

Reals vertices_of(const TriangleMesh& mesh) {
  Reals out({static_cast<py::ssize_t>(mesh.data->vertices.size()), py::ssize_t{3}});
  auto view = out.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < view.shape(0); ++i) {
    for (int k = 0; k < 3; ++k) view(i, k) = mesh.data->vertices[i][k];
  }
  return out;
}

py::array_t<std::int32_t> triangles_of(const TriangleMesh& mesh) {
  py::array_t<std::int32_t> out(
      {static_cast<py::ssize_t>(mesh.data->triangles.size()), py::ssize_t{3}});
  auto view = out.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < view.shape(0); ++i) {
    for (int k = 0; k < 3; ++k) view(i, k) = mesh.data->triangles[i][k];
  }
  return out;
}

Reals heights_of(const HeightField& field) {
  Reals out({field.data->rows, field.data->columns});
  std::copy(field.data->heights.begin(), field.data->heights.end(), out.mutable_data());
  return out;
}

py::tuple spacing_of(const HeightField& field) {
  return py::make_tuple(field.data->spacing.x(), field.data->spacing.y());
}

bool same(const MeshData& a, const MeshData& b) {
  return a.vertices == b.vertices && a.triangles == b.triangles;
}
bool same(const HeightData& a, const HeightData& b) {
  return a.rows == b.rows && a.columns == b.columns && a.spacing == b.spacing &&
         a.heights == b.heights;
}

// Equality and hash by content, as for the other shapes.
template <class T>
void compare_by_content(py::class_<T>& type) {
  type.def("__eq__", [](const T& self, const py::object& other) -> py::object {
    if (!py::isinstance<T>(other)) return py::reinterpret_borrow<py::object>(Py_NotImplemented);
    return py::bool_(same(*self.data, *other.cast<const T&>().data));
  });
}

}  // namespace

void define_surfaces(py::module_& m) {
  py::class_<TriangleMesh> mesh(m, "TriangleMesh",
                                "Static surface of triangles, counterclockwise seen from outside: "
                                "`vertices` (n, 3) m, `triangles` (m, 3) indices; equal vertices "
                                "are merged. A closed mesh is solid. An open one is a sheet "
                                "without mass that stops bodies on either side (particles on the "
                                "outside only): which, their centre says.");
  mesh.def(py::init(&make_mesh_of), py::arg("vertices"), py::arg("triangles"))
      .def_property_readonly("vertices", &vertices_of, "(n, 3), m; merged.")
      .def_property_readonly("triangles", &triangles_of, "(m, 3), indices of `vertices`.")
      .def_property_readonly(
          "closed", [](const TriangleMesh& s) { return s.data->closed; },
          "True when every edge has two triangles.")
      .def("__repr__",
           [](const TriangleMesh& s) {
             return "TriangleMesh(" + std::to_string(s.data->vertices.size()) + " vertices, " +
                    std::to_string(s.data->triangles.size()) + " triangles)";
           })
      .def("__hash__",
           [](const TriangleMesh& s) {
             return py::hash(py::make_tuple("TriangleMesh", vertices_of(s).attr("tobytes")(),
                                            triangles_of(s).attr("tobytes")()));
           })
      .def("__reduce__", [](const py::object& self) {
        const auto& s = self.cast<const TriangleMesh&>();
        return py::make_tuple(py::type::of(self), py::make_tuple(vertices_of(s), triangles_of(s)));
      });
  compare_by_content(mesh);

  py::class_<HeightField> field(m, "HeightField",
                                "Static surface over a grid, solid below (as deep as half its "
                                "diagonal): `heights` (n, m), m; heights[i, j] lies at "
                                "x = i spacing, y = j spacing. `spacing`: m, one number or "
                                "two.");
  field.def(py::init(&make_field_of), py::arg("heights"), py::arg("spacing"))
      .def_property_readonly("heights", &heights_of, "(n, m), m.")
      .def_property_readonly("spacing", &spacing_of, "(along x, along y), m.")
      .def("__repr__",
           [](const HeightField& s) {
             return "HeightField(" + std::to_string(s.data->rows) + " x " +
                    std::to_string(s.data->columns) + " heights)";
           })
      .def("__hash__",
           [](const HeightField& s) {
             return py::hash(py::make_tuple("HeightField", spacing_of(s),
                                            heights_of(s).attr("tobytes")(), s.data->rows));
           })
      .def("__reduce__", [](const py::object& self) {
        const auto& s = self.cast<const HeightField&>();
        return py::make_tuple(py::type::of(self), py::make_tuple(heights_of(s), spacing_of(s)));
      });
  compare_by_content(field);
}

}  // namespace rb
