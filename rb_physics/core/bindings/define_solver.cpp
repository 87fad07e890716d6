// rb_physics._core.solver: contact problems in numbers, the solvers and the residual, on NumPy
// arrays. For tests and for those who bring their own contacts.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <optional>
#include <stdexcept>
#include <string>

#include "contact/problem.hpp"
#include "solver/contact_solver.hpp"
#include "solver/impact_law.hpp"
#include "solver/normal_delassus.hpp"
#include "solver/normal_impact.hpp"
#include "solver/residual.hpp"
#include "solver/resting.hpp"
#include "solver/wide_level.hpp"

namespace py = pybind11;

namespace rb {
namespace {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;
using IntArray = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;

void expect_shape(const py::array& a, const char* name, const std::vector<py::ssize_t>& shape) {
  bool same = a.ndim() == static_cast<py::ssize_t>(shape.size());
  for (std::size_t k = 0; same && k < shape.size(); ++k) same = a.shape(k) == shape[k];
  if (same) return;
  std::string text;
  for (const py::ssize_t n : shape) text += (text.empty() ? "" : ", ") + std::to_string(n);
  throw std::invalid_argument(std::string(name) + " must have shape (" + text + ")");
}

using Matrix3Rows = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

std::vector<Vec3> vectors(const std::optional<Array>& a, const char* name, py::ssize_t n) {
  std::vector<Vec3> out(n, Vec3::Zero());
  if (!a) return out;
  expect_shape(*a, name, {n, 3});
  for (py::ssize_t i = 0; i < n; ++i) out[i] = Eigen::Map<const Vec3>(a->data(i, 0));
  return out;
}

std::vector<double> numbers(const std::optional<Array>& a, const char* name, py::ssize_t n) {
  std::vector<double> out(n, 0.0);
  if (!a) return out;
  expect_shape(*a, name, {n});
  for (py::ssize_t i = 0; i < n; ++i) out[i] = a->at(i);
  return out;
}

ContactProblem make_problem(const Array& inv_mass, const Array& inv_inertia, const Array& velocity,
                            const IntArray& bodies, const Array& r_a, const Array& frame,
                            const std::optional<Array>& r_b, const std::optional<Array>& bias,
                            const std::optional<Array>& angular_bias,
                            const std::optional<Array>& friction,
                            const std::optional<Array>& static_friction,
                            const std::optional<Array>& rolling_friction,
                            const std::optional<Array>& spinning_friction,
                            const std::optional<Array>& restitution) {
  ContactProblem p;
  const py::ssize_t nb = inv_mass.size();
  expect_shape(inv_mass, "inv_mass", {nb});
  expect_shape(inv_inertia, "inv_inertia", {nb, 3, 3});
  expect_shape(velocity, "velocity", {nb, 6});
  for (py::ssize_t i = 0; i < nb; ++i) {
    p.inv_mass.push_back(inv_mass.at(i));
    p.inv_inertia.push_back(Matrix3Rows(inv_inertia.data(i, 0, 0)));
    p.velocity.push_back(Eigen::Map<const Vec6>(velocity.data(i, 0)));
  }
  const py::ssize_t nc = bodies.ndim() > 0 ? bodies.shape(0) : 0;
  expect_shape(bodies, "bodies", {nc, 2});
  expect_shape(frame, "frame", {nc, 3, 3});
  const std::vector<Vec3> arm_a = vectors(r_a, "r_a", nc);
  const std::vector<Vec3> arm_b = vectors(r_b, "r_b", nc);
  const std::vector<Vec3> u = vectors(bias, "bias", nc);
  const std::vector<Vec3> w = vectors(angular_bias, "angular_bias", nc);
  const std::vector<double> kinetic = numbers(friction, "friction", nc);
  const std::vector<double> sticking = numbers(static_friction, "static_friction", nc);
  const std::vector<double> rolling = numbers(rolling_friction, "rolling_friction", nc);
  const std::vector<double> spinning = numbers(spinning_friction, "spinning_friction", nc);
  const std::vector<double> epsilon = numbers(restitution, "restitution", nc);
  for (py::ssize_t i = 0; i < nc; ++i) {
    ContactConstraint c;
    c.a = bodies.at(i, 0);
    c.b = bodies.at(i, 1);
    c.r_a = arm_a[i];
    c.r_b = arm_b[i];
    c.frame = Matrix3Rows(frame.data(i, 0, 0));
    c.bias = u[i];
    c.angular_bias = w[i];
    c.friction = kinetic[i];
    c.static_friction = sticking[i];
    c.rolling_friction = rolling[i];
    c.spinning_friction = spinning[i];
    c.restitution = epsilon[i];
    p.contacts.push_back(c);
  }
  check_problem(p);
  return p;
}

template <typename V>
Array rows(const std::vector<V>& v) {
  constexpr int kSize = V::RowsAtCompileTime;
  Array out({static_cast<py::ssize_t>(v.size()), static_cast<py::ssize_t>(kSize)});
  for (std::size_t i = 0; i < v.size(); ++i) {
    for (int k = 0; k < kSize; ++k) out.mutable_at(i, k) = v[i][k];
  }
  return out;
}

template <typename V>
std::vector<V> from_rows(const Array& a, const char* name) {
  constexpr int kSize = V::RowsAtCompileTime;
  const py::ssize_t n = a.ndim() > 0 ? a.shape(0) : 0;
  if (n == 0) return {};
  expect_shape(a, name, {n, kSize});
  std::vector<V> out(n);
  for (py::ssize_t i = 0; i < n; ++i) out[i] = Eigen::Map<const V>(a.data(i, 0));
  return out;
}

void define_problem(py::module_& m) {
  py::class_<ContactProblem>(m, "ContactProblem",
                             "Contacts in numbers; see core/contact/problem.hpp for the symbols.")
      .def(py::init(&make_problem), py::arg("inv_mass"), py::arg("inv_inertia"),
           py::arg("velocity"), py::arg("bodies"), py::arg("r_a"), py::arg("frame"), py::kw_only(),
           py::arg("r_b") = py::none(), py::arg("bias") = py::none(),
           py::arg("angular_bias") = py::none(), py::arg("friction") = py::none(),
           py::arg("static_friction") = py::none(), py::arg("rolling_friction") = py::none(),
           py::arg("spinning_friction") = py::none(), py::arg("restitution") = py::none());

  py::class_<ContactSolution>(m, "ContactSolution")
      .def(py::init([](const std::optional<Array>& impulse, const std::optional<Array>& moment) {
             ContactSolution s;
             if (impulse) s.impulse = from_rows<Vec3>(*impulse, "impulse");
             if (moment) s.moment = from_rows<Vec3>(*moment, "moment");
             return s;
           }),
           py::arg("impulse") = py::none(), py::arg("moment") = py::none())
      .def_property_readonly("impulse", [](const ContactSolution& s) { return rows(s.impulse); })
      .def_property_readonly("moment", [](const ContactSolution& s) { return rows(s.moment); })
      .def_property_readonly("velocity", [](const ContactSolution& s) { return rows(s.velocity); })
      .def_property_readonly("certificate",
                             [](const ContactSolution& s) { return rows(s.certificate); })
      .def_readonly("residual", &ContactSolution::residual)
      .def_readonly("iterations", &ContactSolution::iterations)
      .def_readonly("converged", &ContactSolution::converged)
      .def_readonly("minimum_norm", &ContactSolution::minimum_norm);
}

void define_report(py::module_& m) {
  py::class_<SolverSettings>(m, "SolverSettings")
      .def(py::init<>())
      .def_readwrite("tolerance", &SolverSettings::tolerance)
      .def_readwrite("warm_tolerance", &SolverSettings::warm_tolerance)
      .def_readwrite("minimum_norm", &SolverSettings::minimum_norm)
      .def_readwrite("max_work", &SolverSettings::max_work)
      .def_readwrite("max_factor_work", &SolverSettings::max_factor_work)
      .def_readwrite("max_sweeps", &SolverSettings::max_sweeps);
  py::class_<SolveReport>(m, "SolveReport")
      .def_readonly("residual", &SolveReport::residual)
      .def_readonly("sweeps", &SolveReport::sweeps)
      .def_readonly("newton_steps", &SolveReport::newton_steps)
      .def_readonly("factorizations", &SolveReport::factorizations)
      .def_readonly("converged", &SolveReport::converged)
      .def_readonly("minimum_norm", &SolveReport::minimum_norm)
      .def_readonly("warm_accepted", &SolveReport::warm_accepted)
      .def_readonly("work_exhausted", &SolveReport::work_exhausted);
}

void define_impact(py::module_& m) {
  py::class_<ImpactConditions>(m, "ImpactConditions")
      .def_readonly("attraction", &ImpactConditions::attraction)
      .def_readonly("penetration", &ImpactConditions::penetration)
      .def_readonly("energy_gain", &ImpactConditions::energy_gain)
      .def_readonly("cone", &ImpactConditions::cone)
      .def("worst", &ImpactConditions::worst);
  py::class_<ImpactReport>(m, "ImpactReport")
      .def_readonly("residual", &ImpactReport::residual)
      .def_readonly("energy_gain", &ImpactReport::energy_gain)
      .def_readonly("iterations", &ImpactReport::iterations)
      .def_readonly("capped", &ImpactReport::capped)
      .def_readonly("conditions", &ImpactReport::conditions);
  m.def(
      "apply_impact",
      [](const ContactProblem& problem, ImpactLaw law) {
        ContactSolution solution;
        SolverWorkspace workspace;
        const ImpactReport report = apply_impact(problem, law, solution, workspace);
        return std::make_pair(solution, report);
      },
      py::arg("problem"), py::arg("law"),
      "Impact law (S11-S14) with friction; returns (ContactSolution, ImpactReport).");
  m.def("single_contact_impulse", &single_contact_impulse, py::arg("d_dot"), py::arg("a"),
        py::arg("restitution"), "Closed form of one contact (S11), N s; S15's bounds asserted.");
}

void define_resting(py::module_& m) {
  py::class_<LcpResult>(m, "LcpResult")
      .def_property_readonly("z", [](const LcpResult& r) { return r.z; })
      .def_readonly("residual", &LcpResult::residual)
      .def_readonly("pivots", &LcpResult::pivots)
      .def_readonly("solved", &LcpResult::solved);
  m.def("lcp_lemke", &lcp_lemke, py::arg("m"), py::arg("q"),
        "w = M z + q, w >= 0, z >= 0, z.w = 0 by Lemke's method, lexicographic.");
  m.def("lcp_pivoting", &lcp_pivoting, py::arg("m"), py::arg("q"),
        "The same by block principal pivoting; least-norm z.");
  m.def("lcp_residual", &lcp_residual, py::arg("m"), py::arg("q"), py::arg("z"),
        "Relative natural-map residual of z: the judge of both methods.");
  m.def("normal_delassus", &normal_delassus, py::arg("problem"),
        "A_ij: speed along N_i per unit impulse along N_j, 1/kg (S14).");
  py::enum_<LcpMethod>(m, "LcpMethod")
      .value("LEMKE", LcpMethod::LEMKE)
      .value("PIVOTING", LcpMethod::PIVOTING);
  m.def(
      "resting_contact",
      [](const ContactProblem& accelerations, LcpMethod method) {
        const RestingContact r = resting_contact(accelerations, method);
        return py::make_tuple(r.force, rows(r.acceleration), r.lcp);
      },
      py::arg("accelerations"), py::arg("method") = LcpMethod::PIVOTING,
      "Resting contact (S16): returns (force g, N; accelerations; LcpResult). The problem's\n"
      "velocity holds accelerations, its bias the velocity-dependent terms of d_dd.");
}

}  // namespace

void define_solver(py::module_& parent) {
  py::module_ m = parent.def_submodule("solver", "Contact problems in numbers and their solvers.");
  define_problem(m);
  define_report(m);
  define_impact(m);
  define_resting(m);
  m.def(
      "simd_levels",
      [] {
        py::dict out;
        for (const wide::Level& level : wide::levels()) out[level.name.c_str()] = level.available;
        return out;
      },
      "Instruction sets the loops of large islands were built for, narrowest first, and whether "
      "this\n"
      "machine has them: {name: bool}.");
  m.def(
      "simd_level", [] { return std::string(wide::chosen_kernel().level); }, "The one in use.");
  m.def("choose_simd_level", &wide::choose_level, py::arg("name"),
        "Use another from now on, in the whole process; bits do not depend on it. ValueError if\n"
        "this machine does not have it.");
  m.def(
      "solve_contacts",
      [](const ContactProblem& problem, const std::optional<ContactSolution>& warm_start,
         const std::optional<SolverSettings>& settings) {
        ContactSolution solution = warm_start ? *warm_start : ContactSolution{};
        SolverWorkspace workspace;
        const SolveReport report =
            solve_contacts(problem, settings ? *settings : SolverSettings{}, solution, workspace);
        return std::make_pair(solution, report);
      },
      py::arg("problem"), py::arg("warm_start") = py::none(), py::arg("settings") = py::none(),
      "Solve with the staged solver; returns (ContactSolution, SolveReport).");
  m.def(
      "natural_map_residual",
      [](const ContactProblem& problem, const ContactSolution& solution) {
        return natural_map_residual(problem, solution);
      },
      py::arg("problem"), py::arg("solution"),
      "Relative natural-map residual of the impulses, the judge of all solvers.");
}

}  // namespace rb
