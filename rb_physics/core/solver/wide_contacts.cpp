#include "solver/wide_contacts.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <new>

#include "solver/wide_level.hpp"

namespace rb {
namespace {

constexpr std::align_val_t kAlignment{64};
constexpr int kLanes = wide::kLanes;

// Rows xx xy xz yy yz zz.
void put_symmetric(double* row, const Mat3& m) {
  const double values[6] = {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
  for (int k = 0; k < 6; ++k) row[kLanes * k] = values[k];
}

void put_vector(double* row, const Vec3& v) {
  for (int k = 0; k < 3; ++k) row[kLanes * k] = v[k];
}

// Eight sums side by side, then pairwise: the same order on every machine.
double difference_sq(const double* x, const double* y, std::size_t n) {
  double s[kLanes] = {};
  for (std::size_t i = 0; i < n; i += kLanes) {
    for (int l = 0; l < kLanes; ++l) {
      const double d = x[i + l] - y[i + l];
      s[l] += d * d;
    }
  }
  return ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
}

// direction = beta direction + (x - saved); x += beta old direction.
void extrapolate(double* x, const double* saved, double* direction, double beta, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    const double push = beta * direction[i];
    const double change = x[i] - saved[i];
    x[i] += push;
    direction[i] = push + change;
  }
}

}  // namespace

void WideArray::Free::operator()(double* p) const { ::operator delete[](p, kAlignment); }

void WideArray::resize(std::size_t n) {
  if (n > capacity_) {
    capacity_ = n + n / 4;
    data_.reset(static_cast<double*>(::operator new[](capacity_ * sizeof(double), kAlignment)));
  }
  size_ = n;
}

wide::View WideContacts::view() const {
  return {groups_.data(),  nobody_,          manifolds_.data(), points_.data(),
          impulse_.data(), velocity_.data(), free_.data()};
}

template <class Call>
void WideContacts::for_colours(bool backward, const Call& call) const {
  const std::size_t n = colour_begin_.size() - 1;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t c = backward ? n - 1 - k : k;
    call(colour_begin_[c], colour_begin_[c + 1]);
  }
}

void WideContacts::load(const ContactProblem& problem, const std::vector<FrictionCone>& cones) {
  lay_out(problem, &cones);
}

void WideContacts::load_frictionless(const ContactProblem& problem) { lay_out(problem, nullptr); }

void WideContacts::lay_out(const ContactProblem& problem, const std::vector<FrictionCone>* cones) {
  kernel_ = &wide::chosen_kernel();
  colours_.build(problem);
  const std::vector<PointRange>& manifolds = colours_.manifolds();
  groups_.clear();
  colour_begin_.clear();
  nobody_ = static_cast<std::int32_t>(problem.inv_mass.size());
  std::int32_t slots = 0;
  for (int c = 0; c < colours_.colour_count(); ++c) {
    colour_begin_.push_back(static_cast<std::int32_t>(groups_.size()));
    for (std::int32_t k = colours_.begin(c); k < colours_.begin(c + 1); k += kLanes) {
      wide::Group group;
      group.slots = manifolds[k].count;  // the first has most
      group.slot = slots;
      group.manifold = wide::kManifoldRows * static_cast<std::int32_t>(groups_.size());
      std::fill(group.a, group.a + kLanes, nobody_);
      std::fill(group.b, group.b + kLanes, nobody_);
      slots += group.slots;
      groups_.push_back(group);
    }
  }
  colour_begin_.push_back(static_cast<std::int32_t>(groups_.size()));

  manifolds_.resize(groups_.size() * wide::kManifoldRows * kLanes);
  points_.resize(static_cast<std::size_t>(slots) * wide::kSlotRows * kLanes);
  impulse_.resize(static_cast<std::size_t>(slots) * 3 * kLanes);
  velocity_.resize(8 * (problem.inv_mass.size() + 1));
  free_.resize(velocity_.size());
  std::memset(manifolds_.data(), 0, manifolds_.size() * sizeof(double));
  std::memset(points_.data(), 0, points_.size() * sizeof(double));
  std::memset(free_.data(), 0, free_.size() * sizeof(double));
  for (std::size_t b = 0; b < problem.velocity.size(); ++b) {
    std::copy_n(problem.velocity[b].data(), 6, free_.data() + 8 * b);
  }

  place_.resize(problem.contacts.size());
  frictionless_ = true;
  for (int c = 0; c < colours_.colour_count(); ++c) {
    const std::int32_t first = colours_.begin(c);
    for (std::int32_t k = first; k < colours_.begin(c + 1); ++k) {
      const int lane = (k - first) % kLanes;
      wide::Group& group = groups_[colour_begin_[c] + (k - first) / kLanes];
      double* m = manifolds_.data() + kLanes * group.manifold + lane;
      const ContactConstraint& head = problem.contacts[manifolds[k].first];
      group.a[lane] = head.a;
      m[kLanes * wide::kMassA] = problem.inv_mass[head.a];
      put_symmetric(m + kLanes * wide::kInertiaA, problem.inv_inertia[head.a]);
      if (head.b >= 0) {
        group.b[lane] = head.b;
        m[kLanes * wide::kMassB] = problem.inv_mass[head.b];
        put_symmetric(m + kLanes * wide::kInertiaB, problem.inv_inertia[head.b]);
      }
      for (int row = 0; row < 3; ++row) {
        put_vector(m + kLanes * (wide::kFrame + 3 * row), head.frame.row(row).transpose());
      }
      for (std::int32_t j = 0; j < manifolds[k].count; ++j) {
        const std::int32_t i = manifolds[k].first + j;
        const ContactConstraint& contact = problem.contacts[i];
        const std::int32_t slot = group.slot + j;
        double* p =
            points_.data() + static_cast<std::size_t>(slot) * wide::kSlotRows * kLanes + lane;
        put_vector(p + kLanes * wide::kArmA, contact.r_a);
        put_vector(p + kLanes * wide::kArmB, contact.r_b);
        put_vector(p + kLanes * wide::kBias, contact.bias);
        const double mu = cones == nullptr ? 0.0 : (*cones)[i].slide;
        p[kLanes * wide::kFriction] = mu;
        p[kLanes * wide::kMass] = 1.0;
        frictionless_ = frictionless_ && mu == 0.0;
        place_[i] = slot * 3 * kLanes + lane;
      }
    }
  }
  kernel_->prepare(view(), 0, static_cast<std::int32_t>(groups_.size()));
}

void WideContacts::refresh() {
  std::copy_n(free_.data(), free_.size(), velocity_.data());
  const wide::View s = view();
  for_colours(false, [&](std::int32_t begin, std::int32_t end) { kernel_->apply(s, begin, end); });
}

void WideContacts::clear_impulses() {
  std::memset(impulse_.data(), 0, impulse_.size() * sizeof(double));
  std::copy_n(free_.data(), free_.size(), velocity_.data());
  last_sq_ = 0.0;
}

void WideContacts::set_impulses(const std::vector<Vec3>& impulse) {
  std::memset(impulse_.data(), 0, impulse_.size() * sizeof(double));
  for (std::size_t i = 0; i < impulse.size(); ++i)
    put_vector(impulse_.data() + place_[i], impulse[i]);
  refresh();
  last_sq_ = 0.0;
}

void WideContacts::impulses(std::vector<Vec3>& impulse) const {
  impulse.resize(place_.size());
  for (std::size_t i = 0; i < place_.size(); ++i) {
    const double* p = impulse_.data() + place_[i];
    impulse[i] = Vec3(p[0], p[kLanes], p[2 * kLanes]);
  }
}

void WideContacts::velocities(std::vector<Vec6>& v) const {
  v.resize(nobody_);
  for (std::int32_t b = 0; b < nobody_; ++b) {
    v[b] = Eigen::Map<const Vec6>(velocity_.data() + 8 * static_cast<std::size_t>(b));
  }
}

void WideContacts::sweep(bool backward) {
  const wide::View s = view();
  const auto call = frictionless_ ? kernel_->sweep_frictionless : kernel_->sweep;
  for_colours(backward,
              [&](std::int32_t begin, std::int32_t end) { call(s, begin, end, backward); });
}

void WideContacts::accelerated_sweep(bool restart) {
  const std::size_t n = impulse_.size();
  const std::size_t nv = velocity_.size();
  saved_impulse_.resize(n);
  saved_velocity_.resize(nv);
  direction_.resize(n);
  velocity_direction_.resize(nv);
  std::copy_n(impulse_.data(), n, saved_impulse_.data());
  std::copy_n(velocity_.data(), nv, saved_velocity_.data());
  sweep(false);
  const double sq = difference_sq(impulse_.data(), saved_impulse_.data(), n);
  const double beta = last_sq_ > 0.0 ? sq / last_sq_ : 0.0;
  last_sq_ = sq;
  if (!(beta < 1.0) || restart || beta == 0.0) {  // uphill, or asked to: start again
    std::memset(direction_.data(), 0, n * sizeof(double));
    std::memset(velocity_direction_.data(), 0, nv * sizeof(double));
    if (!(beta < 1.0)) last_sq_ = 0.0;
    return;
  }
  extrapolate(impulse_.data(), saved_impulse_.data(), direction_.data(), beta, n);
  extrapolate(velocity_.data(), saved_velocity_.data(), velocity_direction_.data(), beta, nv);
}

WideResidual WideContacts::measure() const {
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  wide::Measure m;
  kernel_->measure(view(), 0, static_cast<std::int32_t>(groups_.size()), 16.0 * epsilon / 1e-9, &m);
  WideResidual r;
  r.absolute = m.worst;
  r.typical_velocity = m.typical;
  if (m.worst != 0.0) {
    r.natural_map = m.typical > 0.0 ? m.worst / m.typical : std::numeric_limits<double>::infinity();
  }
  if (m.typical > 0.0) r.floor = 16.0 * epsilon * m.operand / m.typical;
  return r;
}

}  // namespace rb
