// Contacts without friction, directly: 0 <= f, A f + d >= 0, f . (A f + d) = 0, with the normal
// rows G of the contact problem, A = G M^-1 G^T, d = G v_free + bias (S14 without rebound, S16).
//
// Block principal pivoting (Judice & Pires 1994; single exchanges, by Murty's rule, where a block
// gains nothing). The rows of A that carry are factorised within their envelope, ordered by
// reverse Cuthill & McKee: A has an entry for every two contacts of a body.
#pragma once

#include <cstdint>
#include <vector>

#include "contact/problem.hpp"

namespace rb {

// Memory that a later solve uses again. Holds no state.
struct FrictionlessWorkspace {
  struct Row {
    Vec3 normal, turn_a, turn_b;  // of G: on A (n, r_A x n), on B the negative of (n, r_B x n)
    Vec3 response_a, response_b;  // J^-1 turn
    double diagonal, d;           // A_ii, 1/kg; d_i, m/s
    std::int32_t a, b;            // bodies
  };
  std::vector<Row> rows;
  struct Coupling {
    std::int32_t contact;
    double value;  // 1/kg; where two contacts share both bodies, one of two parts
  };
  std::vector<std::int32_t> first_of_body, of_body;  // contacts of each body
  std::vector<std::int32_t> first_coupling, next_coupling;
  std::vector<Coupling> couplings;              // of each contact: what A has beside the diagonal
  std::vector<std::uint8_t> carries;            // the active set
  std::vector<std::int32_t> all, order, place;  // all contacts, and those that carry, in order
  std::vector<std::int32_t> first, start;  // of each row of the envelope: column, place in `lower`
  std::vector<double> lower, inverse;      // L; 1 / L_ii, 0 where the row depends on earlier ones
  std::vector<double> force, speed, right, centre;
  std::vector<Vec6> velocity;
};

struct FrictionlessOptions {
  bool unique = true;     // give up where the carrying contacts depend on each other
  double max_work = 3e6;  // multiply-adds of a factorisation
  double rounding = 0.0;  // m/s: slower approaches are none
};

struct FrictionlessReport {
  bool solved = false;
  bool unique = false;  // no contact that carries depends on others
  int factorizations = 0;
  double work = 0.0;  // multiply-adds
};

// `impulse` in: a guess, and `velocity` what it makes of v_free: they tell which contacts carry, to
// begin with; out: the answer, if solved. `certificate`, if the answer is unique: see
// ContactSolution. A contact that depends on others carries nothing.
FrictionlessReport solve_frictionless(const ContactProblem& problem,
                                      const FrictionlessOptions& options,
                                      const std::vector<Vec6>& velocity,
                                      FrictionlessWorkspace& workspace, std::vector<Vec3>& impulse,
                                      std::vector<Vec6>& certificate);

}  // namespace rb
