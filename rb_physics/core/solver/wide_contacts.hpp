// A contact problem laid out for the wide kernels (wide_kernel.hpp): structure of arrays, coloured.
// Contacts without rolling and spinning friction only.
#pragma once

#include <vector>

#include "contact/problem.hpp"
#include "math/crew.hpp"
#include "solver/friction_cone.hpp"
#include "solver/manifold_colours.hpp"
#include "solver/wide_array.hpp"
#include "solver/wide_kernel.hpp"

namespace rb {

struct WideResidual {
  double absolute = 0.0;          // m/s, as the bias
  double natural_map = 0.0;       // relative, as ContactResidual
  double typical_velocity = 0.0;  // m/s
  double floor = 0.0;             // what rounding leaves of the residual
};

class WideContacts {
 public:
  // Threads that share the work from now on; null: none but the caller's.
  void use(Workers* workers) { workers_ = workers; }
  // Calls lead(), within which everything below is shared among the threads.
  template <class Lead>
  void together(const Lead& lead) {
    crew_.run(workers_, lead);
  }

  // Within together(): piece(k) for every k in [0, n).
  template <class Piece>
  void share(std::int32_t n, const Piece& piece) {
    crew_.share(n, piece);
  }

  // Lays the problem out, with the coefficients of `cones` or none.
  void load(const ContactProblem& problem, const std::vector<FrictionCone>& cones);
  void load_frictionless(const ContactProblem& problem);

  // And the velocities they make.
  void set_impulses(const std::vector<Vec3>& impulse);
  void clear_impulses();
  void impulses(std::vector<Vec3>& impulse) const;
  void velocities(std::vector<Vec6>& v) const;

  void sweep();
  WideResidual measure();
  // One sweep and a step of the nonsmooth nonlinear conjugate gradient method; `restart` leaves it
  // a plain sweep.
  void accelerated_sweep(bool restart);

 private:
  wide::View view();
  void lay_out(const ContactProblem& problem, const std::vector<FrictionCone>* cones);
  void fill_group(const ContactProblem& problem, const std::vector<FrictionCone>* cones, int colour,
                  std::int32_t group);
  void start_acceleration();
  template <class Call>
  void for_colours(const Call& call);
  template <class Call>
  void for_groups(const Call& call);
  template <class Call>
  void for_blocks(std::size_t n, const Call& call);

  Workers* workers_ = nullptr;
  Crew crew_;
  const wide::Kernel* kernel_ = nullptr;
  ManifoldColours colours_;
  std::vector<wide::Group> groups_;
  std::vector<std::int32_t> colour_begin_;  // groups of each colour
  std::vector<std::int32_t> place_;         // of a contact: its first double in `impulse_`
  std::int32_t nobody_ = 0;
  bool frictionless_ = false;
  double typical_free_ = 0.0;  // m/s
  WideArray manifolds_, points_, impulse_, velocity_, free_;
  WideArray last_impulse_, last_velocity_, direction_, velocity_direction_;
  std::vector<double> partial_;
  std::vector<wide::Measure> measured_;
  double last_sq_ = 0.0;
};

}  // namespace rb
