#include "solver/normal_delassus.hpp"

#include "solver/contact_operators.hpp"

namespace rb {

Eigen::MatrixXd normal_delassus(const ContactProblem& problem) {
  const Eigen::Index n = static_cast<Eigen::Index>(problem.contacts.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  struct Row {  // wrench of a unit impulse, and the velocity it gives, on both bodies
    Vec6 wrench_a, wrench_b, velocity_a, velocity_b;
  };
  std::vector<Row> rows(n);
  const auto response = [&problem](int body, const Vec6& wrench) {
    Vec6 v;
    v.head<3>() = problem.inv_mass[body] * wrench.head<3>();
    v.tail<3>() = problem.inv_inertia[body] * wrench.tail<3>();
    return v;
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    const ContactConstraint& c = problem.contacts[i];
    const Vec3 normal = c.frame.row(0).transpose();
    rows[i].wrench_a << normal, c.r_a.cross(normal);
    rows[i].velocity_a = response(c.a, rows[i].wrench_a);
    if (c.b < 0) continue;
    rows[i].wrench_b << -normal, -c.r_b.cross(normal);
    rows[i].velocity_b = response(c.b, rows[i].wrench_b);
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const ContactConstraint& c = problem.contacts[i];
    for (Eigen::Index j = 0; j <= i; ++j) {
      const ContactConstraint& k = problem.contacts[j];
      double s = 0.0;
      if (c.a == k.a) s += rows[i].wrench_a.dot(rows[j].velocity_a);
      if (c.a == k.b) s += rows[i].wrench_a.dot(rows[j].velocity_b);
      if (c.b >= 0 && c.b == k.a) s += rows[i].wrench_b.dot(rows[j].velocity_a);
      if (c.b >= 0 && c.b == k.b) s += rows[i].wrench_b.dot(rows[j].velocity_b);
      a(i, j) = a(j, i) = s;
    }
  }
  return a;
}

Eigen::VectorXd normal_speeds(const ContactProblem& problem, const std::vector<Vec6>& v) {
  Eigen::VectorXd d(static_cast<Eigen::Index>(problem.contacts.size()));
  for (Eigen::Index i = 0; i < d.size(); ++i) d[i] = relative_velocity(problem.contacts[i], v)[0];
  return d;
}

void apply_normal_impulses(const ContactProblem& problem, const Eigen::VectorXd& f,
                           std::vector<Vec6>& v) {
  for (Eigen::Index i = 0; i < f.size(); ++i) {
    if (f[i] != 0.0) apply_impulse(problem, problem.contacts[i], Vec3(f[i], 0.0, 0.0), v);
  }
}

}  // namespace rb
