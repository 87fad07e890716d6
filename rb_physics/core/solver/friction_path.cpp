#include "solver/friction_path.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "solver/contact_operators.hpp"

namespace rb {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kFirstShare = 0.1;   // of the coefficients
constexpr double kLeastShare = 1e-6;  // shorter pieces: there is no path
constexpr double kGrow = 1.7, kShrink = 0.4;
constexpr double kOnPath = 1e-9;  // relative: near enough to go on
constexpr double kArrived = 1e-13;
constexpr int kMostSteps = 40;  // in one place; at the start ten times as many
constexpr double kLeastStride = 1e-8;
constexpr double kSoftness = 1e-13;  // relative: redundant contacts share

// In the unknowns z_i = w_i lambda_i (m/s; moments divided by the cone's length).
class Path {
 public:
  Path(const ContactProblem& problem, const ContactScales& scales,
       const std::vector<FrictionCone>& cones, const std::vector<Vec3>& impulse,
       const std::vector<Vec3>& moment)
      : problem_(problem), scales_(scales), cones_(cones), width_(moment.empty() ? 3 : 6) {
    const bool moments = !moment.empty();
    const Index n = width_ * static_cast<Index>(cones.size());
    u0_ = slips(problem.velocity, true);
    a_.resize(n, n);
    std::vector<Vec6> v;
    for (Index k = 0; k < n; ++k) {
      const std::size_t i = k / width_;
      const Index row = k % width_;
      v.assign(problem.velocity.size(), Vec6::Zero());
      Vec3 unit = Vec3::Zero();
      unit[row % 3] = 1.0 / scales.w[i];
      if (row < 3) {
        apply_impulse(problem, problem.contacts[i], unit, v);
      } else {
        apply_moment(problem, problem.contacts[i], cones[i].length * unit, v);
      }
      a_.col(k) = slips(v, false);
    }
    a_.diagonal() += VectorXd::Constant(n, kSoftness);
    speed_ = *std::max_element(scales.speed.begin(), scales.speed.end());
    z_ = VectorXd::Zero(n);
    for (std::size_t i = 0; i < cones.size(); ++i) {
      const Index at = width_ * static_cast<Index>(i);
      z_.segment<3>(at) = scales.w[i] * impulse[i];
      if (moments) z_.segment<3>(at + 3) = (scales.w[i] / cones[i].length) * moment[i];
    }
  }

  FrictionPathReport follow(int max_steps) {
    FrictionPathReport report;
    report.arrived = settle(1.0, kArrived, kMostSteps, report.steps);
    if (report.arrived || report.steps >= max_steps) return report;
    z_.setZero();
    double share = 0.0, piece = kFirstShare;
    report.arrived = settle(0.0, kOnPath, 10 * kMostSteps, report.steps);
    while (share < 1.0 && piece > kLeastShare && report.steps < max_steps) {
      const double next = std::min(1.0, share + piece);
      const VectorXd before = z_;
      report.arrived = settle(next, next < 1.0 ? kOnPath : kArrived, kMostSteps, report.steps);
      if (report.arrived) {
        share = next;
        piece *= kGrow;
      } else {
        z_ = before;
        piece *= kShrink;
      }
    }
    report.arrived = share >= 1.0;
    // A branch may turn back before it is there; others are found from elsewhere.
    const VectorXd last = z_;
    for (const double part : {0.0, 0.1, 0.3, 3.0, 10.0}) {
      if (report.arrived || report.steps >= max_steps) break;
      z_ = part * last;
      report.arrived = settle(1.0, kArrived, kMostSteps, report.steps);
    }
    if (report.arrived) return report;
    report.arrived = go_round(2 * max_steps, report.steps);
    if (!report.arrived) z_ = last;
    return report;
  }

  void answer(std::vector<Vec3>& impulse, std::vector<Vec3>& moment) const {
    for (std::size_t i = 0; i < cones_.size(); ++i) {
      const Reaction at = reaction(z_, i);
      const Reaction p = project_on_cone(cones_[i], at, nullptr);
      impulse[i] = p.force / scales_.w[i];
      if (width_ == 6) moment[i] = (cones_[i].length / scales_.w[i]) * p.moment;
    }
  }

 private:
  VectorXd slips(const std::vector<Vec6>& v, bool with_bias) const {
    VectorXd out(width_ * static_cast<Index>(cones_.size()));
    for (std::size_t i = 0; i < cones_.size(); ++i) {
      const ContactConstraint& c = problem_.contacts[i];
      const Index at = width_ * static_cast<Index>(i);
      out.segment<3>(at) = with_bias ? relative_velocity(c, v) : relative_motion(c, v);
      if (width_ < 6) continue;
      out.segment<3>(at + 3) =
          cones_[i].length * (with_bias ? relative_spin(c, v) : relative_turning(c, v));
    }
    return out;
  }

  Reaction reaction(const VectorXd& x, std::size_t i) const {
    const Index at = width_ * static_cast<Index>(i);
    Reaction r;
    r.force = x.segment<3>(at);
    if (width_ == 6) r.moment = x.segment<3>(at + 3);
    return r;
  }

  FrictionCone cone(std::size_t i, double share) const {
    FrictionCone c = cones_[i];
    c.slide *= share;
    c.spin *= share;
    c.roll *= share;
    return c;
  }

  // The natural map at z, and its generalised Jacobian.
  VectorXd map(const VectorXd& z, double share, MatrixXd* jacobian) const {
    const VectorXd u = a_ * z + u0_;
    VectorXd r(z.size());
    for (std::size_t i = 0; i < cones_.size(); ++i) {
      const Index at = width_ * static_cast<Index>(i);
      const FrictionCone c = cone(i, share);
      const Reaction x = reaction(z, i), slip = reaction(u, i);
      const Reaction s = de_saxce(c, slip);
      ReactionDerivative d;
      const Reaction p = project_on_cone(c, {x.force - s.force, x.moment - s.moment},
                                         jacobian != nullptr ? &d : nullptr);
      r.segment<3>(at) = x.force - p.force;
      if (width_ == 6) r.segment<3>(at + 3) = x.moment - p.moment;
      if (jacobian == nullptr) continue;
      // I - D (I - E A), E = d(de_saxce) / d(slip).
      MatrixXd of_z = MatrixXd::Zero(width_, width_);
      of_z.topLeftCorner<3, 3>() = d.ff;
      MatrixXd e = MatrixXd::Identity(width_, width_);
      const auto add = [&](double mu, Index from, Index count) {
        const VectorXd part = u.segment(at + from, count);
        const double size = part.norm();
        if (size > 0.0) e.block(0, from, 1, count) += (mu / size) * part.transpose();
      };
      add(c.slide, 1, 2);
      if (width_ == 6) {
        if (c.has_moment()) {
          of_z.topRightCorner<3, 3>() = d.fm;
          of_z.bottomLeftCorner<3, 3>() = d.mf;
          of_z.bottomRightCorner<3, 3>() = d.mm;
        }
        add(c.spin, 3, 1);
        add(c.roll, 4, 2);
      }
      jacobian->middleRows(at, width_).noalias() = (of_z * e) * a_.middleRows(at, width_);
      jacobian->block(at, at, width_, width_) += MatrixXd::Identity(width_, width_) - of_z;
    }
    return r;
  }

  // The branch of answers as a curve in (z, share), by its length: where it turns back, share falls
  // for a while.
  bool go_round(int max_steps, int& steps) {
    constexpr int most_corrections = 10;
    constexpr double least_piece = 1e-10;
    const Index n = z_.size();
    z_.setZero();
    if (!settle(0.0, kOnPath, 10 * kMostSteps, steps)) return false;
    double share = 0.0, piece = kFirstShare;
    VectorXd ahead = VectorXd::Unit(n + 1, n);
    MatrixXd m(n + 1, n + 1);
    while (steps < max_steps && share > -1.0) {
      const double scale = std::max(speed_, z_.cwiseAbs().maxCoeff());
      const auto linear = [&](const VectorXd& z, double at, const VectorXd& along) {
        constexpr double d = 1e-7;
        MatrixXd jacobian(n, n);
        const VectorXd r = map(z, at, &jacobian);
        m.topLeftCorner(n, n) = jacobian;
        m.topRightCorner(n, 1) = (map(z, at + d, nullptr) - r) / (d * scale);
        m.bottomRows(1) = along.transpose();
        ++steps;
        return r;
      };
      linear(z_, share, ahead);
      VectorXd tangent = m.partialPivLu().solve(VectorXd::Unit(n + 1, n));
      if (!tangent.allFinite()) return false;
      tangent.normalize();
      bool found = false;
      VectorXd z;
      double at = 0.0;
      for (; !found && piece > least_piece && steps < max_steps; piece *= found ? 1.0 : 0.5) {
        z = z_ + piece * scale * tangent.head(n);
        at = share + piece * tangent[n];
        const VectorXd z_ahead = z;
        const double at_ahead = at;
        for (int k = 0; k < most_corrections && !found; ++k) {
          VectorXd r(n + 1);
          r.head(n) = linear(z, at, tangent) / scale;
          r[n] = tangent.head(n).dot(z - z_ahead) / scale + tangent[n] * (at - at_ahead);
          found = r.cwiseAbs().maxCoeff() <= kOnPath;
          if (found) {
            if (k < 4) piece *= 2.0;
            break;
          }
          const VectorXd step = m.partialPivLu().solve(r);
          if (!(step.cwiseAbs().maxCoeff() < 1e3)) break;
          z -= scale * step.head(n);
          at -= step[n];
        }
      }
      if (!found) return false;
      if (at >= 1.0) {
        const double part = (1.0 - share) / (at - share);
        const VectorXd before = z_;
        z_ += part * (z - z_);
        if (settle(1.0, kArrived, kMostSteps, steps)) return true;
        z_ = before;
      }
      ahead.head(n) = (z - z_) / scale;
      ahead[n] = at - share;
      ahead.normalize();
      z_ = z;
      share = at;
    }
    return false;
  }

  bool settle(double share, double tolerance, int most, int& steps) {
    MatrixXd jacobian(z_.size(), z_.size());
    for (int k = 0; k < most; ++k) {
      const VectorXd r = map(z_, share, &jacobian);
      const double size = r.norm();
      const double scale = std::max(speed_, z_.cwiseAbs().maxCoeff());
      if (r.cwiseAbs().maxCoeff() <= tolerance * scale) return true;
      ++steps;
      const VectorXd step = jacobian.partialPivLu().solve(-r);
      if (!step.allFinite()) return false;
      double stride = 1.0;
      bool nearer = false;
      for (; stride > kLeastStride && !nearer; stride *= 0.5) {
        const VectorXd next = z_ + stride * step;
        nearer = map(next, share, nullptr).norm() < (1.0 - 1e-4 * stride) * size;
        if (nearer) z_ = next;
      }
      if (!nearer) return r.cwiseAbs().maxCoeff() <= kOnPath * scale;  // rounding
    }
    return false;
  }

  const ContactProblem& problem_;
  const ContactScales& scales_;
  const std::vector<FrictionCone>& cones_;
  const Index width_;  // components of a contact
  MatrixXd a_;
  VectorXd u0_, z_;
  double speed_ = 0.0;  // m/s
};

}  // namespace

FrictionPathReport friction_path(const ContactProblem& problem, const ContactScales& scales,
                                 const std::vector<FrictionCone>& cones, int max_steps,
                                 std::vector<Vec3>& impulse, std::vector<Vec3>& moment) {
  Path path(problem, scales, cones, impulse, moment);
  const FrictionPathReport report = path.follow(max_steps);
  path.answer(impulse, moment);
  return report;
}

}  // namespace rb
