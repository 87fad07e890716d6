#include "solver/body_space.hpp"

#include <cmath>

namespace rb {
namespace {

// Lower Cholesky factor of a positive semidefinite matrix; locked axes give zero columns.
Mat3 semidefinite_cholesky(const Mat3& a) {
  Mat3 l = Mat3::Zero();
  const double tiny = 1e-14 * a.trace();
  for (int k = 0; k < 3; ++k) {
    double d = a(k, k);
    for (int m = 0; m < k; ++m) d -= l(k, m) * l(k, m);
    if (!(d > tiny)) continue;
    l(k, k) = std::sqrt(d);
    for (int i = k + 1; i < 3; ++i) {
      double s = a(i, k);
      for (int m = 0; m < k; ++m) s -= l(i, m) * l(k, m);
      l(i, k) = s / l(k, k);
    }
  }
  return l;
}

// -[r]x b: velocity of the point r per unit of scaled rotation.
Mat3 lever(const Vec3& r, const Mat3& b) {
  Mat3 t;
  for (int k = 0; k < 3; ++k) t.col(k) = b.col(k).cross(r);
  return t;
}

bool equal(const Mat3& x, const Mat3& y) { return (x.array() == y.array()).all(); }

bool is_normal(const Mat3& k) {
  return k.bottomRows<2>().isZero(0.0) && k(0, 1) == 0.0 && k(0, 2) == 0.0;
}

// One contact's world-axes stiffness, and the levers of a side.
struct Stiffness {
  Mat3 ff, fm, mf, mm;
  bool moment;
};

struct Side {
  double s;
  const Mat3* b;
  Mat3 t;
};

// Block (row side, column side) of (J B)^T K (J B), without the sign.
Mat6 stiffness_block(const Stiffness& k, const Side& row, const Side& column) {
  Mat3 angular = k.ff * column.t;  // force per scaled rotation
  if (k.moment) angular += k.fm * *column.b;
  Mat6 h;
  h.topLeftCorner<3, 3>() = (row.s * column.s) * k.ff;
  h.topRightCorner<3, 3>() = row.s * angular;
  Mat3 bottom_left = row.t.transpose() * k.ff;
  Mat3 bottom_right = row.t.transpose() * angular;
  if (k.moment) {
    bottom_left += row.b->transpose() * k.mf;
    bottom_right += row.b->transpose() * (k.mf * column.t + k.mm * *column.b);
  }
  h.bottomLeftCorner<3, 3>() = column.s * bottom_left;
  h.bottomRightCorner<3, 3>() = bottom_right;
  return h;
}

// h += k times the same block for K = 1: what sticks.
void add_sticking(double k, const Side& row, const Side& column, Mat6& h) {
  h.diagonal().head<3>().array() += k * row.s * column.s;
  h.topRightCorner<3, 3>() += (k * row.s) * column.t;
  h.bottomLeftCorner<3, 3>() += (k * column.s) * row.t.transpose();
  h.bottomRightCorner<3, 3>() += k * (row.t.transpose() * column.t);
}

// h += k times the same block for K = n n^T: what is held along its normal.
void add_held(double k, const Vec3& n, const Side& row, const Side& column, Mat6& h) {
  Vec6 x, y;
  x << row.s * n, row.t.transpose() * n;
  y << column.s * n, column.t.transpose() * n;
  h += (k * x) * y.transpose();
}

}  // namespace

bool BodySpace::prepare(const ContactProblem& problem, double max_work) {
  factored_ = false;
  factorizations_ = 0;
  if (!graph_.analyze(problem, max_work)) return false;
  const std::size_t nb = problem.inv_mass.size();
  linear_.resize(nb);
  angular_.resize(nb);
  for (std::size_t i = 0; i < nb; ++i) {
    linear_[i] = std::sqrt(problem.inv_mass[i]);
    angular_[i] = semidefinite_cholesky(problem.inv_inertia[i]);
  }
  return true;
}

bool BodySpace::is_last(const std::vector<FrictionCone>& cones,
                        const std::vector<ReactionDerivative>& d, double weight,
                        bool symmetric) const {
  if (!factored_ || weight != last_weight_ || symmetric != factor_.symmetric()) return false;
  for (std::size_t i = 0; i < d.size(); ++i) {
    if (!equal(d[i].ff, last_d_[i].ff)) return false;
    if (!cones[i].has_moment()) continue;
    if (!equal(d[i].fm, last_d_[i].fm) || !equal(d[i].mf, last_d_[i].mf) ||
        !equal(d[i].mm, last_d_[i].mm)) {
      return false;
    }
  }
  return true;
}

bool BodySpace::factorize(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                          const std::vector<ReactionDerivative>& d, double weight, bool symmetric) {
  if (is_last(cones, d, weight, symmetric)) return true;
  factor_.reset(graph_, symmetric);
  assemble(problem, cones, d, weight);
  last_d_ = d;
  last_weight_ = weight;
  ++factorizations_;
  factored_ = factor_.factorize(graph_);
  return factored_;
}

void BodySpace::assemble(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                         const std::vector<ReactionDerivative>& d, double weight) {
  for (std::size_t i = 0; i < problem.contacts.size(); ++i) {
    const ContactConstraint& c = problem.contacts[i];
    const bool moment = cones[i].has_moment();
    const Mat3& ff = d[i].ff;
    if (!moment && ff.isZero(0.0)) continue;  // open
    const Side a{linear_[c.a], &angular_[c.a], lever(c.r_a, angular_[c.a])};
    const int pa = graph_.position(c.a);
    const bool sticks = !moment && equal(ff, Mat3::Identity());
    if (sticks || (!moment && is_normal(ff))) {
      const Vec3 n = c.frame.row(0);
      const auto add = [&](double k, const Side& row, const Side& column, Mat6& h) {
        sticks ? add_sticking(k, row, column, h) : add_held(k * ff(0, 0), n, row, column, h);
      };
      add(weight, a, a, factor_.diagonal(pa));
      if (c.b < 0) continue;
      const Side b{linear_[c.b], &angular_[c.b], lever(c.r_b, angular_[c.b])};
      const int pb = graph_.position(c.b);
      add(weight, b, b, factor_.diagonal(pb));
      const int block = graph_.pair_block(static_cast<int>(i));
      add(-weight, pa > pb ? a : b, pa > pb ? b : a, factor_.lower(block));
      if (!factor_.symmetric())
        add(-weight, pa > pb ? b : a, pa > pb ? a : b, factor_.upper(block));
      continue;
    }
    const Mat3 ft = weight * c.frame.transpose();
    Stiffness k;
    k.moment = moment;
    k.ff = ft * d[i].ff * c.frame;
    if (k.moment) {
      k.fm = ft * (cones[i].length * d[i].fm) * c.frame;
      k.mf = ft * (cones[i].length * d[i].mf) * c.frame;
      k.mm = ft * (cones[i].length * cones[i].length * d[i].mm) * c.frame;
    }
    factor_.diagonal(pa) += stiffness_block(k, a, a);
    if (c.b < 0) continue;
    const Side b{linear_[c.b], &angular_[c.b], lever(c.r_b, angular_[c.b])};
    const int pb = graph_.position(c.b);
    factor_.diagonal(pb) += stiffness_block(k, b, b);
    const int block = graph_.pair_block(static_cast<int>(i));
    const bool a_later = pa > pb;
    factor_.lower(block) -= a_later ? stiffness_block(k, a, b) : stiffness_block(k, b, a);
    if (!factor_.symmetric()) {
      factor_.upper(block) -= a_later ? stiffness_block(k, b, a) : stiffness_block(k, a, b);
    }
  }
}

void BodySpace::solve(std::vector<Vec6>& x) {
  const int nb = graph_.body_count();
  ordered_.resize(nb);
  for (int i = 0; i < nb; ++i) ordered_[graph_.position(i)] = x[i];
  factor_.solve(graph_, ordered_);
  for (int i = 0; i < nb; ++i) x[i] = ordered_[graph_.position(i)];
}

void BodySpace::velocity(const ContactProblem& problem, const std::vector<Vec6>& z,
                         std::vector<Vec6>& v) const {
  v.resize(z.size());
  for (std::size_t i = 0; i < z.size(); ++i) {
    v[i].head<3>() = problem.velocity[i].head<3>() + linear_[i] * z[i].head<3>();
    v[i].tail<3>() = problem.velocity[i].tail<3>() + angular_[i] * z[i].tail<3>();
  }
}

void BodySpace::scale(const std::vector<Vec6>& z, std::vector<Vec6>& x) const {
  x.resize(z.size());
  for (std::size_t i = 0; i < z.size(); ++i) {
    x[i].head<3>() = linear_[i] * z[i].head<3>();
    x[i].tail<3>() = angular_[i] * z[i].tail<3>();
  }
}

void BodySpace::scale_transposed(const std::vector<Vec6>& p, std::vector<Vec6>& z) const {
  z.resize(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    z[i].head<3>() = linear_[i] * p[i].head<3>();
    z[i].tail<3>() = angular_[i].transpose() * p[i].tail<3>();
  }
}

}  // namespace rb
