// A contact problem laid out for the wide kernels (wide_kernel.hpp): structure of arrays, coloured.
// Contacts without rolling and spinning friction only.
#pragma once

#include <memory>
#include <vector>

#include "contact/problem.hpp"
#include "solver/friction_cone.hpp"
#include "solver/manifold_colours.hpp"
#include "solver/wide_kernel.hpp"

namespace rb {

// Doubles at addresses that suit the widest registers. Grows, never shrinks.
class WideArray {
 public:
  void resize(std::size_t n);  // old contents are lost when it grows
  double* data() { return data_.get(); }
  const double* data() const { return data_.get(); }
  std::size_t size() const { return size_; }

 private:
  struct Free {
    void operator()(double* p) const;
  };
  std::unique_ptr<double[], Free> data_;
  std::size_t size_ = 0, capacity_ = 0;
};

struct WideResidual {
  double absolute = 0.0;          // m/s, as the bias
  double natural_map = 0.0;       // relative, as ContactResidual
  double typical_velocity = 0.0;  // m/s
  double floor = 0.0;             // what rounding leaves of the residual
};

class WideContacts {
 public:
  // Lays the problem out with the coefficients of `cones`.
  void load(const ContactProblem& problem, const std::vector<FrictionCone>& cones);

  void load_frictionless(const ContactProblem& problem);

  void clear_impulses();
  void set_impulses(const std::vector<Vec3>& impulse);  // and the velocities they make
  void impulses(std::vector<Vec3>& impulse) const;
  void velocities(std::vector<Vec6>& v) const;

  void sweep(bool backward);
  WideResidual measure() const;
  // One sweep and a step of the nonsmooth nonlinear conjugate gradient method; `restart` leaves it
  // a plain sweep.
  void accelerated_sweep(bool restart);
  // Velocities anew from the impulses: rounding of many sweeps out.
  void refresh();

 private:
  wide::View view() const;
  void lay_out(const ContactProblem& problem, const std::vector<FrictionCone>* cones);
  template <class Call>
  void for_colours(bool backward, const Call& call) const;

  const wide::Kernel* kernel_ = nullptr;
  ManifoldColours colours_;
  std::vector<wide::Group> groups_;
  std::vector<std::int32_t> colour_begin_;  // groups of each colour
  std::vector<std::int32_t> place_;         // of a contact: its first double in `impulse_`
  std::int32_t nobody_ = 0;
  bool frictionless_ = false;
  mutable WideArray manifolds_, points_, impulse_, velocity_, free_;
  WideArray saved_impulse_, saved_velocity_, direction_, velocity_direction_;
  double last_sq_ = 0.0;
};

}  // namespace rb
