// The broad phase for tests and benchmarks; a World has its own inside.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "collision/broad_phase.hpp"

namespace py = pybind11;

namespace rb {
namespace {

using Rows = py::array_t<double, py::array::c_style | py::array::forcecast>;

Vec3 row(const Rows& a, py::ssize_t i) { return {a.at(i, 0), a.at(i, 1), a.at(i, 2)}; }

py::ssize_t rows(const Rows& a) {
  if (a.ndim() != 2 || a.shape(1) != 3) {
    throw std::invalid_argument("expected an array of shape (n, 3)");
  }
  return a.shape(0);
}

py::array_t<std::int32_t> as_array(const std::vector<std::pair<int, int>>& pairs) {
  py::array_t<std::int32_t> out({static_cast<py::ssize_t>(pairs.size()), py::ssize_t{2}});
  auto view = out.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < view.shape(0); ++i) {
    view(i, 0) = pairs[i].first;
    view(i, 1) = pairs[i].second;
  }
  return out;
}

int insert(BroadPhase& self, const Vec3& lower, const Vec3& upper, std::uint32_t layer,
           std::uint32_t mask, bool passive) {
  return self.insert({lower, upper}, {layer, mask}, passive);
}

int insert_half_space(BroadPhase& self, const Vec3& normal, double offset, std::uint32_t layer,
                      std::uint32_t mask) {
  return self.insert_half_space(normal, offset, {layer, mask});
}

void move(BroadPhase& self, int body, const Vec3& lower, const Vec3& upper,
          const Vec3& displacement) {
  self.move(body, {lower, upper}, displacement);
}

void move_all(BroadPhase& self, const Rows& lower, const Rows& upper,
              const std::optional<Rows>& displacement) {
  const py::ssize_t n = rows(lower);
  if (rows(upper) != n || (displacement && rows(*displacement) != n) || n > self.size()) {
    throw std::invalid_argument(
        "lower, upper and displacement need the same number of rows, <= len()");
  }
  for (py::ssize_t i = 0; i < n; ++i) {
    self.move(static_cast<int>(i), {row(lower, i), row(upper, i)},
              displacement ? row(*displacement, i) : Vec3(Vec3::Zero()));
  }
}

std::vector<int> query(const BroadPhase& self, const Vec3& lower, const Vec3& upper) {
  std::vector<int> out;
  self.query({lower, upper}, out);
  return out;
}

std::vector<int> ray(const BroadPhase& self, const Vec3& origin, const Vec3& direction,
                     double t_max) {
  std::vector<int> out;
  self.ray(origin, direction, t_max, [&](int body) {
    out.push_back(body);
    return t_max;
  });
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

void define_broad_phase(py::module_& m) {
  const Vec3 zero = Vec3::Zero();
  py::class_<BroadPhase>(m, "BroadPhase",
                         "Dynamic AABB tree: pairs of bodies whose predicted boxes overlap.")
      .def(py::init<double>(), py::arg("fat_margin") = 0.1)
      .def("insert", &insert, py::arg("lower"), py::arg("upper"), py::arg("layer") = 1u,
           py::arg("mask") = 0xffffffffu, py::arg("passive") = false,
           "Add a body by its box, m; returns its number.")
      .def("insert_half_space", &insert_half_space, py::arg("normal"), py::arg("offset"),
           py::arg("layer") = 1u, py::arg("mask") = 0xffffffffu,
           "Add a passive half-space normal . x <= offset; returns its number.")
      .def("remove", &BroadPhase::remove, py::arg("body"), "Later bodies move down by one.")
      .def("move", &move, py::arg("body"), py::arg("lower"), py::arg("upper"),
           py::arg("displacement") = zero, "New box and expected displacement, m.")
      .def("move_all", &move_all, py::arg("lower"), py::arg("upper"),
           py::arg("displacement") = py::none(),
           "Move bodies 0 .. n - 1 at once; arrays of shape (n, 3), m.")
      .def(
          "update_pairs", [](BroadPhase& self) { return as_array(self.update_pairs()); },
          "Pairs (a, b), a < b, sorted: int32 array of shape (n, 2).")
      .def(
          "update_count", [](BroadPhase& self) { return self.update_pairs().size(); },
          "update_pairs without copying the pairs: their number.")
      .def("query", &query, py::arg("lower"), py::arg("upper"),
           "Bodies whose predicted box meets the box, ascending.")
      .def("ray", &ray, py::arg("origin"), py::arg("direction"), py::arg("t_max"),
           "Bodies whose predicted box the ray may enter, ascending.")
      .def_property_readonly("candidates", &BroadPhase::candidates,
                             "Pairs of overlapping fat boxes kept between updates.")
      .def_property_readonly(
          "height", [](const BroadPhase& self) { return self.moving_tree().height(); },
          "Longest path in the tree of moving bodies.")
      .def("__len__", &BroadPhase::size);
}

}  // namespace rb
