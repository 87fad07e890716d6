// rb_physics._core.Batch: many worlds stepped in one call, read and set as arrays (n, N, ...). The
// worlds are Python's; a batch keeps them alive. The Python face is batch.py.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>
#include <memory>
#include <optional>

#include "bindings/arrays.hpp"
#include "bindings/body_state.hpp"
#include "math/rotation.hpp"
#include "math/workers.hpp"
#include "world/step.hpp"
#include "world/world.hpp"

namespace rb {

void hold(Body& body, const AppliedWrench& wrench);  // define_wrenches.cpp

namespace {

using bindings::set_pose;

struct Batch {
  std::vector<py::object> owners;
  std::vector<World*> worlds;
  std::unique_ptr<Workers> workers;
};

// Variation and what diverged in it.
using Trouble = std::pair<std::size_t, DivergedInfo>;

// Every variation makes its steps, whatever happens to the others.
std::optional<Trouble> step_all(Batch& batch, std::uint64_t n) {
  std::vector<std::optional<DivergedInfo>> diverged(batch.worlds.size());
  {
    const py::gil_scoped_release release;
    batch.workers->run(batch.worlds.size(), [&](int, std::size_t k) {
      try {
        for (std::uint64_t i = 0; i < n; ++i) step(*batch.worlds[k]);
      } catch (const Diverged& e) {
        diverged[k] = e.info;
      }
    });
  }
  for (std::size_t k = 0; k < diverged.size(); ++k) {
    if (diverged[k]) return Trouble{k, *diverged[k]};
  }
  return std::nullopt;
}

std::size_t body_count(const Batch& batch) {
  const std::size_t count = batch.worlds.empty() ? 0 : batch.worlds[0]->bodies.size();
  for (const World* w : batch.worlds) {
    if (w->bodies.size() != count)
      throw py::value_error("the variations have different numbers of bodies: no array holds them");
  }
  return count;
}

template <int width, class Fill>
py::array_t<double> gather(const Batch& batch, Fill fill) {
  const auto n = static_cast<py::ssize_t>(batch.worlds.size());
  py::array_t<double> out({n, static_cast<py::ssize_t>(body_count(batch)), py::ssize_t{width}});
  double* p = out.mutable_data();
  for (const World* w : batch.worlds) {
    for (const Body& body : w->bodies) {
      fill(*w, body, p);
      p += width;
    }
  }
  return out;
}

template <int width, class Take>
void scatter(Batch& batch, const InputArray& values, Take take) {
  const auto n = static_cast<py::ssize_t>(batch.worlds.size());
  const auto count = static_cast<py::ssize_t>(body_count(batch));
  if (values.ndim() != 3 || values.shape(0) != n || values.shape(1) != count ||
      values.shape(2) != width) {
    throw py::value_error("expected an array of shape (" + std::to_string(n) + ", " +
                          std::to_string(count) + ", " + std::to_string(width) + ")");
  }
  const double* p = values.data();
  std::vector<RigidState> before;
  for (const World* w : batch.worlds) {
    for (const Body& body : w->bodies) before.push_back(body.state);
  }
  const auto all = [&](auto act) {
    std::size_t k = 0;
    for (World* w : batch.worlds) {
      w->geometry_dirty = true;
      for (Body& body : w->bodies) act(*w, body, k++);
    }
  };
  try {
    all([&](World& w, Body& body, std::size_t k) { take(w, body, p + width * k); });
  } catch (...) {  // none is set
    all([&](World&, Body& body, std::size_t k) { body.state = before[k]; });
    throw;
  }
}

// The state set from three numbers, finite or refused.
template <class Change>
void change(Body& body, const char* field, const double* p, Change act) {
  bindings::change_state(body, field, InputArray(3, p), act);
}

// Forces and torques on the centres of mass, world axes; zero rows of both leave a body alone.
void apply(Batch& batch, const InputArray& forces, const InputArray& torques, double duration) {
  const std::size_t size = 3 * batch.worlds.size() * body_count(batch);
  if (static_cast<std::size_t>(torques.size()) != size)
    throw py::value_error("torques must have the shape of forces");
  const double* t = torques.data();
  scatter<3>(batch, forces, [&](World&, Body& b, const double* f) {
    AppliedWrench a;
    a.frame = WrenchFrame::WORLD;
    a.force = Vec3(f[0], f[1], f[2]);
    a.torque = Vec3(t[0], t[1], t[2]);
    a.at_center = true;
    a.remaining = duration;
    t += 3;
    if (b.is_dynamic()) hold(b, a);
  });
}

}  // namespace

void define_batch(py::module_& m) {
  py::class_<Batch>(m, "Batch")
      .def(py::init([](const std::vector<py::object>& owners, int threads) {
             auto batch = std::make_unique<Batch>();
             batch->owners = owners;
             for (const py::object& owner : owners) batch->worlds.push_back(owner.cast<World*>());
             batch->workers = std::make_unique<Workers>(threads);
             return batch;
           }),
           py::arg("worlds"), py::arg("threads"))
      .def("_step",
           [](Batch& batch, std::uint64_t n) -> py::object {
             const std::optional<Trouble> trouble = step_all(batch, n);
             if (!trouble) return py::none();
             return py::make_tuple(trouble->first, trouble->second.step, trouble->second.body);
           })
      .def("_positions",
           [](const Batch& batch) {
             return gather<3>(
                 batch, [](const World&, const Body& b, double* p) { put(p, b.pose().position); });
           })
      .def("_orientations",
           [](const Batch& batch) {
             return gather<4>(batch, [](const World&, const Body& b, double* p) {
               for (int i = 0; i < 4; ++i) p[i] = b.state.q.coeffs()[i];
             });
           })
      .def("_linear_velocities",
           [](const Batch& batch) {
             return gather<3>(batch, [](const World&, const Body& b, double* p) {
               put(p, b.linear_velocity());
             });
           })
      .def("_angular_velocities",
           [](const Batch& batch) {
             return gather<3>(batch, [](const World&, const Body& b, double* p) {
               put(p, b.angular_velocity());
             });
           })
      .def("_contact_wrenches",
           [](const Batch& batch) {
             return gather<6>(batch, [](const World& w, const Body& b, double* p) {
               put(p, b.contact_impulse / w.settings.dt);
               put(p + 3, b.contact_moment / w.settings.dt);
             });
           })
      .def("_state_hashes",
           [](const Batch& batch) {
             py::array_t<std::uint64_t> out(static_cast<py::ssize_t>(batch.worlds.size()));
             for (std::size_t k = 0; k < batch.worlds.size(); ++k)
               out.mutable_data()[k] = state_hash(*batch.worlds[k]);
             return out;
           })
      .def("_set_positions",
           [](Batch& batch, const InputArray& x) {
             scatter<3>(batch, x, [](World&, Body& b, const double* p) {
               change(b, "positions", p, [&](Body& c) {
                 set_pose(c, {Vec3(p[0], p[1], p[2]), c.state.q});
               });
             });
           })
      .def("_set_orientations",
           [](Batch& batch, const InputArray& q) {
             scatter<4>(batch, q, [](World&, Body& b, const double* p) {
               set_pose(b, {b.pose().position, normalized(Quat(p[3], p[0], p[1], p[2]))});
             });
           })
      .def("_set_linear_velocities",
           [](Batch& batch, const InputArray& v) {
             scatter<3>(batch, v, [](World&, Body& b, const double* p) {
               if (b.type == BodyType::STATIC) return;
               change(b, "linear_velocities", p,
                      [&](Body& c) { c.set_linear_velocity(Vec3(p[0], p[1], p[2])); });
             });
           })
      .def("_set_angular_velocities",
           [](Batch& batch, const InputArray& v) {
             scatter<3>(batch, v, [](World&, Body& b, const double* p) {
               if (b.type == BodyType::STATIC) return;
               change(b, "angular_velocities", p,
                      [&](Body& c) { c.set_angular_velocity(Vec3(p[0], p[1], p[2])); });
             });
           })
      .def("_apply_wrenches", &apply);
}

}  // namespace rb
