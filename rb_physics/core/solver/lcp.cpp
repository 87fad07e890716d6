#include "solver/lcp.hpp"

#include <algorithm>
#include <cmath>

namespace rb {

double lcp_residual(const Eigen::MatrixXd& m, const Eigen::VectorXd& q, const Eigen::VectorXd& z) {
  const Eigen::Index n = q.size();
  if (n == 0) return 0.0;
  const Eigen::VectorXd w = m * z + q;
  const double floor = m.trace() / (static_cast<double>(n) * static_cast<double>(n));
  double worst = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double r = std::abs(std::min(std::max(m(i, i), floor) * z[i], w[i]));
    if (!(r <= worst)) worst = r;
  }
  const double scale = q.cwiseAbs().maxCoeff();
  return worst == 0.0 ? 0.0 : worst / scale;
}

}  // namespace rb
