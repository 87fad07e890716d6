// One contact solved exactly while all others hold: find lambda with
//   u = W lambda + q,  Coulomb's law (coefficient mu) between u and lambda.
//
// Open if q_n >= 0; sticks if -W^-1 q lies in the cone; otherwise slides with u_n = 0 and
// lambda_t = -(W~ + beta I)^-1 q~, W~ and q~ with the normal eliminated, beta = |u_t|/|lambda_t|
// the root of |lambda_t(beta)| = mu lambda_n(beta) (the bisection of Hwangbo et al. 2018, on slip
// over impulse, so that the impulse is exactly opposite to the slip). A root exists whenever q_n <
// 0.
#pragma once

#include "math/types.hpp"

namespace rb {

Vec3 solve_local_contact(const Mat3& w, const Vec3& q, double mu);

// Tangential impulse of least energy within a given bound: |t| <= bound, u = w t + q, opposite to
// the slip it leaves, or stopping it. w positive definite.
Vec2 solve_local_slip(const Eigen::Matrix2d& w, const Vec2& q, double bound);

}  // namespace rb
