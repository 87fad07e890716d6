#include "solver/resting.hpp"

#include "solver/normal_delassus.hpp"

namespace rb {

RestingContact resting_contact(const ContactProblem& accelerations, LcpMethod method) {
  RestingContact out;
  const Eigen::MatrixXd a = normal_delassus(accelerations);
  const Eigen::VectorXd b = normal_speeds(accelerations, accelerations.velocity);
  out.lcp = method == LcpMethod::LEMKE ? lcp_lemke(a, b) : lcp_pivoting(a, b);
  out.force = out.lcp.z;
  out.acceleration = accelerations.velocity;
  apply_normal_impulses(accelerations, out.force, out.acceleration);
  return out;
}

}  // namespace rb
