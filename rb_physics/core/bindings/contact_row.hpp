// world.contacts as a numpy structured array.
#pragma once

#include <pybind11/numpy.h>

#include "world/world.hpp"

namespace rb {

namespace py = pybind11;

// One row of world.contacts; the field order is public.
struct ContactRow {
  std::int32_t body_a;
  std::int32_t body_b;
  double point[3];
  double normal[3];
  double separation;
  double force[3];
  double impulse[3];
  std::int64_t feature;
  std::uint8_t kind;
  std::uint8_t state;
};

// Indices into world.contacts of the rows that are shown: touching or with an impulse in the last
// step.
std::vector<std::int32_t> shown_contacts(const World& world);

py::array_t<ContactRow> contact_rows(const World& world);

void define_contact_row(py::module_& m);

}  // namespace rb
