#include "bindings/contact_row.hpp"

namespace rb {

std::vector<std::int32_t> shown_contacts(const World& world) {
  std::vector<std::int32_t> shown;
  for (std::size_t i = 0; i < world.contacts.size(); ++i) {
    const Contact& c = world.contacts[i];
    if ((c.active() && c.touching()) || !c.impulse.isZero(0.0))
      shown.push_back(static_cast<std::int32_t>(i));
  }
  return shown;
}

py::array_t<ContactRow> contact_rows(const World& world) {
  const std::vector<std::int32_t> shown = shown_contacts(world);
  py::array_t<ContactRow> out(static_cast<py::ssize_t>(shown.size()));
  ContactRow* row = out.mutable_data();
  for (const std::int32_t i : shown) {
    const Contact& c = world.contacts[i];
    *row = {};
    row->body_a = c.body_a;
    row->body_b = c.body_b;
    const Vec3 point = 0.5 * (c.point.point_a + c.point.point_b);
    for (int k = 0; k < 3; ++k) {
      row->point[k] = point[k];
      row->normal[k] = c.point.normal[k];
      row->force[k] = c.impulse[k] / world.settings.dt;
      row->impulse[k] = c.impulse[k];
    }
    row->separation = c.point.separation;
    row->feature = c.point.feature;
    row->kind = static_cast<std::uint8_t>(c.point.kind);
    row->state = static_cast<std::uint8_t>(c.state);
    ++row;
  }
  return out;
}

void define_contact_row(py::module_&) {
  PYBIND11_NUMPY_DTYPE(ContactRow, body_a, body_b, point, normal, separation, force, impulse,
                       feature, kind, state);
}

}  // namespace rb
