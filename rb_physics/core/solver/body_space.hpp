// Linear algebra in body coordinates. With M^-1 = B B^T and v = v_free + B z (z in square roots of
// energy, so that mass ratios do not spoil the conditioning and locked axes just drop out), the
// matrices of all Newton steps are
//   H = I + weight * B^T J^T D J B,   D block diagonal, 3x3 (or 6x6 with moments) per contact.
#pragma once

#include <vector>

#include "contact/problem.hpp"
#include "solver/block_factor.hpp"
#include "solver/body_graph.hpp"
#include "solver/friction_cone.hpp"

namespace rb {

class BodySpace {
 public:
  // Analyses the graph and factors M^-1. False if the factorisation would exceed max_work.
  bool prepare(const ContactProblem& problem, double max_work);

  // Assembles and factors H. Skipped when D and weight are those of the last factorisation.
  // False if H is singular.
  bool factorize(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                 const std::vector<ReactionDerivative>& d, double weight, bool symmetric);
  // x := H^-1 x, by body.
  void solve(std::vector<Vec6>& x);

  // v = v_free + B z and x = B z; z = B^T p for body wrenches p.
  void velocity(const ContactProblem& problem, const std::vector<Vec6>& z,
                std::vector<Vec6>& v) const;
  void scale(const std::vector<Vec6>& z, std::vector<Vec6>& x) const;
  void scale_transposed(const std::vector<Vec6>& p, std::vector<Vec6>& z) const;

  int factorizations() const { return factorizations_; }
  bool is_jam() const { return graph_.is_jam(); }  // after prepare()
  double factor_work() const { return graph_.factor_work(); }

 private:
  void assemble(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                const std::vector<ReactionDerivative>& d, double weight);
  bool is_last(const std::vector<FrictionCone>& cones, const std::vector<ReactionDerivative>& d,
               double weight, bool symmetric) const;

  BodyGraph graph_;
  BlockFactor factor_;
  std::vector<double> linear_;  // B = diag(linear, linear, linear, angular), per body
  std::vector<Mat3> angular_;   // lower triangular
  std::vector<ReactionDerivative> last_d_;
  double last_weight_ = 0.0;
  bool factored_ = false;
  int factorizations_ = 0;
  std::vector<Vec6> ordered_;
};

// p += J_i^T reaction as wrenches on the bodies about their centres of mass, world axes. Inline,
// like the projection: handed over in memory, a reaction stored number by number is waited for.
[[gnu::always_inline]] inline void add_wrench(const ContactConstraint& c, const FrictionCone& cone,
                                              const Reaction& reaction, std::vector<Vec6>& p) {
  const Vec3 f = c.frame.transpose() * reaction.force;
  Vec3 m = Vec3::Zero();
  if (cone.has_moment()) m = c.frame.transpose() * (cone.length * reaction.moment);
  p[c.a].head<3>() += f;
  p[c.a].tail<3>() += c.r_a.cross(f) + m;
  if (c.b >= 0) {
    p[c.b].head<3>() -= f;
    p[c.b].tail<3>() -= c.r_b.cross(f) + m;
  }
}

}  // namespace rb
