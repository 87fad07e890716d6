// A contact problem laid out for the wide kernels (wide_kernel.hpp): structure of arrays, coloured.
// Contacts without rolling and spinning friction only.
#pragma once

#include <utility>
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
  void use(Crew* crew) { crew_ = crew; }
  // Of what else there is to do for a problem, too: see Crew::share_range.
  template <class Piece>
  void share_range(std::size_t n, std::size_t least, const Piece& piece) const {
    if (crew_ != nullptr) return crew_->share_range(n, least, piece);
    if (n > 0) piece(std::size_t{0}, n);
  }

  // Lays the problem out, with the coefficients of `cones` or none.
  void load(const ContactProblem& problem, const std::vector<FrictionCone>& cones);
  // Its first part alone, which needs no cones. While another thread does it, this one calls
  // `other`; without another one nothing is done, and `load` will.
  template <class Other>
  void begin_load(const ContactProblem& problem, const Other& other) {
    if (crew_ == nullptr || !crew_->helped()) return other();
    crew_->share(2, [&](int, std::int32_t k) { k == 0 ? other() : make_groups(problem, nullptr); });
    begun_ = true;
  }
  void load_frictionless(const ContactProblem& problem);
  // The problem that was loaded last, with other biases, inertias and velocities only.
  void reload_frictionless(const ContactProblem& problem);
  void forget() {
    groups_.clear();
    begun_ = false;
  }
  bool loaded() const { return !groups_.empty(); }

  // And the velocities they make.
  void set_impulses(const std::vector<Vec3>& impulse);
  void clear_impulses();
  void impulses(std::vector<Vec3>& impulse) const;
  void velocities(std::vector<Vec6>& v) const;

  WideResidual measure();
  // One sweep and a step of the nonsmooth nonlinear conjugate gradient method; `restart` leaves it
  // a plain sweep.
  void accelerated_sweep(bool restart);

 private:
  wide::View view();
  void lay_out(const ContactProblem& problem, const std::vector<FrictionCone>* cones);
  void cut_colours();
  void make_groups(const ContactProblem& problem, Crew* crew);
  void fill(const ContactProblem& problem, const std::vector<FrictionCone>* cones, bool anew);
  void fill_group(const ContactProblem& problem, const std::vector<FrictionCone>* cones,
                  std::size_t colour, std::int32_t group);
  void refill_group(const ContactProblem& problem, std::size_t colour, std::int32_t group);
  void set_free(const ContactProblem& problem);
  void start_acceleration();
  template <class Call>
  void for_colours(const Call& call);
  template <class Call>
  void for_parts(const Call& call);
  std::pair<std::int64_t, std::int64_t> impulses_of(std::int32_t begin, std::int32_t end) const;

  Crew* crew_ = nullptr;
  const wide::Kernel* kernel_ = nullptr;
  ManifoldColours colours_;
  std::vector<wide::Group> groups_;
  std::vector<std::int32_t> colour_begin_;  // groups of each colour
  std::int32_t parts_ = 1;                  // of every colour
  std::vector<std::int32_t> cuts_;          // of each colour: parts_ + 1 groups where parts begin
  std::vector<std::int32_t> place_;         // of a contact: its first double in `impulse_`
  std::int32_t nobody_ = 0;
  bool begun_ = false;  // groups are those of the problem to be loaded
  bool frictionless_ = false;
  double typical_free_ = 0.0;  // m/s
  WideArray manifolds_, points_, impulse_, velocity_, free_;
  WideArray last_impulse_, last_velocity_, direction_, velocity_direction_;
  std::vector<double> partial_;          // per group
  std::vector<wide::Measure> measured_;  // per part
  double last_sq_ = 0.0;
};

}  // namespace rb
