#include "solver/wide_contacts.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "solver/wide_level.hpp"

namespace rb {
namespace {

constexpr int kLanes = wide::kLanes;
// Pieces of work, the same for any number of threads: results of reductions depend on them.
constexpr std::int32_t kGroupBlock = 4;
constexpr std::size_t kArrayBlock = 4096;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// Rows xx xy xz yy yz zz.
void put_symmetric(double* row, const Mat3& m) {
  const double values[6] = {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
  for (int k = 0; k < 6; ++k) row[kLanes * k] = values[k];
}

void put_vector(double* row, const Vec3& v) {
  for (int k = 0; k < 3; ++k) row[kLanes * k] = v[k];
}

void set_zero(WideArray& a) { std::memset(a.data(), 0, a.size() * sizeof(double)); }

}  // namespace

wide::View WideContacts::view() {
  return {groups_.data(),  nobody_,          manifolds_.data(), points_.data(),
          impulse_.data(), velocity_.data(), free_.data()};
}

// call(begin, end) of groups: colour after colour, the groups of one shared.
template <class Call>
void WideContacts::for_colours(const Call& call) {
  for (std::size_t c = 0; c + 1 < colour_begin_.size(); ++c) {
    const std::int32_t begin = colour_begin_[c];
    const std::int32_t end = colour_begin_[c + 1];
    crew_.share((end - begin + kGroupBlock - 1) / kGroupBlock, [&](std::int32_t k) {
      call(begin + k * kGroupBlock, std::min(end, begin + (k + 1) * kGroupBlock));
    });
  }
}

// call(k, begin, end) of all groups, in blocks.
template <class Call>
void WideContacts::for_groups(const Call& call) {
  constexpr std::int32_t block = 8 * kGroupBlock;
  const auto n = static_cast<std::int32_t>(groups_.size());
  crew_.share((n + block - 1) / block,
              [&](std::int32_t k) { call(k, k * block, std::min(n, (k + 1) * block)); });
}

// call(k, begin, end) of an array of n numbers, in blocks.
template <class Call>
void WideContacts::for_blocks(std::size_t n, const Call& call) {
  crew_.share(static_cast<std::int32_t>((n + kArrayBlock - 1) / kArrayBlock), [&](std::int32_t k) {
    const auto begin = static_cast<std::size_t>(k) * kArrayBlock;
    call(k, static_cast<std::int64_t>(begin),
         static_cast<std::int64_t>(std::min(n, begin + kArrayBlock)));
  });
}

void WideContacts::load(const ContactProblem& problem, const std::vector<FrictionCone>& cones) {
  lay_out(problem, &cones);
}

void WideContacts::load_frictionless(const ContactProblem& problem) { lay_out(problem, nullptr); }

void WideContacts::fill_group(const ContactProblem& problem, const std::vector<FrictionCone>* cones,
                              int colour, std::int32_t group_index) {
  const std::vector<PointRange>& manifolds = colours_.manifolds();
  wide::Group& group = groups_[group_index];
  double* rows = manifolds_.data() + kLanes * static_cast<std::size_t>(group.manifold);
  double* slots = points_.data() + static_cast<std::size_t>(group.slot) * wide::kSlotRows * kLanes;
  std::memset(rows, 0, sizeof(double) * wide::kManifoldRows * kLanes);
  std::memset(slots, 0, sizeof(double) * wide::kSlotRows * kLanes * group.slots);
  const std::int32_t first =
      colours_.begin(colour) + (group_index - colour_begin_[colour]) * kLanes;
  const int lanes = std::min(kLanes, colours_.begin(colour + 1) - first);
  for (int lane = 0; lane < lanes; ++lane) {
    const PointRange& range = manifolds[first + lane];
    const ContactConstraint& head = problem.contacts[range.first];
    double* m = rows + lane;
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
    for (std::int32_t j = 0; j < range.count; ++j) {
      const std::int32_t i = range.first + j;
      const ContactConstraint& contact = problem.contacts[i];
      double* p = slots + j * wide::kSlotRows * kLanes + lane;
      put_vector(p + kLanes * wide::kArmA, contact.r_a);
      put_vector(p + kLanes * wide::kArmB, contact.r_b);
      put_vector(p + kLanes * wide::kBias, contact.bias);
      p[kLanes * wide::kFriction] = cones == nullptr ? 0.0 : (*cones)[i].slide;
      p[kLanes * wide::kMass] = 1.0;
      place_[i] = (group.slot + j) * 3 * kLanes + lane;
    }
  }
}

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
  set_zero(free_);
  for (std::size_t b = 0; b < problem.velocity.size(); ++b) {
    std::copy_n(problem.velocity[b].data(), 6, free_.data() + 8 * b);
  }
  place_.resize(problem.contacts.size());
  frictionless_ = cones == nullptr || std::all_of(cones->begin(), cones->end(),
                                                  [](const auto& c) { return c.slide == 0.0; });
  measured_.resize(groups_.size());
  for_groups([&](std::int32_t k, std::int32_t begin, std::int32_t end) {
    const auto after = std::upper_bound(colour_begin_.begin(), colour_begin_.end(), begin);
    int colour = static_cast<int>(after - colour_begin_.begin()) - 1;
    for (std::int32_t g = begin; g < end; ++g) {
      while (g >= colour_begin_[colour + 1]) ++colour;
      fill_group(problem, cones, colour, g);
    }
    kernel_->prepare(view(), begin, end);
    kernel_->measure_free(view(), begin, end, 16.0 * kEpsilon / 1e-9, &measured_[k]);
  });
  typical_free_ = 0.0;
  const auto blocks = (groups_.size() + 8 * kGroupBlock - 1) / (8 * kGroupBlock);
  for (std::size_t k = 0; k < blocks; ++k) {
    typical_free_ = std::max(typical_free_, measured_[k].typical);
  }
}

void WideContacts::start_acceleration() {
  last_sq_ = 0.0;
  last_impulse_.resize(impulse_.size());
  last_velocity_.resize(velocity_.size());
  direction_.resize(impulse_.size());
  velocity_direction_.resize(velocity_.size());
  std::copy_n(impulse_.data(), impulse_.size(), last_impulse_.data());
  std::copy_n(velocity_.data(), velocity_.size(), last_velocity_.data());
  set_zero(direction_);
  set_zero(velocity_direction_);
}

void WideContacts::clear_impulses() {
  set_zero(impulse_);
  std::copy_n(free_.data(), free_.size(), velocity_.data());
  start_acceleration();
}

void WideContacts::set_impulses(const std::vector<Vec3>& impulse) {
  set_zero(impulse_);
  for (std::size_t i = 0; i < impulse.size(); ++i) {
    put_vector(impulse_.data() + place_[i], impulse[i]);
  }
  std::copy_n(free_.data(), free_.size(), velocity_.data());
  const wide::View s = view();
  for_colours([&](std::int32_t begin, std::int32_t end) { kernel_->apply(s, begin, end); });
  start_acceleration();
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

void WideContacts::sweep() {
  const wide::View s = view();
  const auto call = frictionless_ ? kernel_->sweep_frictionless : kernel_->sweep;
  for_colours([&](std::int32_t begin, std::int32_t end) { call(s, begin, end); });
}

void WideContacts::accelerated_sweep(bool restart) {
  const std::size_t n = impulse_.size();
  sweep();
  partial_.resize((n + kArrayBlock - 1) / kArrayBlock);
  for_blocks(n, [&](std::int32_t k, std::int64_t begin, std::int64_t end) {
    partial_[k] = kernel_->difference_sq(impulse_.data(), last_impulse_.data(), begin, end);
  });
  double sq = 0.0;
  for (const double part : partial_) sq += part;
  const double beta = last_sq_ > 0.0 ? sq / last_sq_ : 0.0;
  last_sq_ = sq;
  if (beta >= 1.0 || restart) {  // uphill, or asked to: start again
    start_acceleration();
    if (restart && beta < 1.0) last_sq_ = sq;
    return;
  }
  for_blocks(n, [&](std::int32_t, std::int64_t begin, std::int64_t end) {
    kernel_->extrapolate(impulse_.data(), last_impulse_.data(), direction_.data(), beta, begin,
                         end);
  });
  kernel_->extrapolate(velocity_.data(), last_velocity_.data(), velocity_direction_.data(), beta, 0,
                       static_cast<std::int64_t>(velocity_.size()));
}

WideResidual WideContacts::measure() {
  const wide::View s = view();
  for_groups([&](std::int32_t k, std::int32_t begin, std::int32_t end) {
    kernel_->measure(s, begin, end, &measured_[k]);
  });
  WideResidual r;
  r.typical_velocity = typical_free_;
  double operand = 0.0;
  const auto blocks = (groups_.size() + 8 * kGroupBlock - 1) / (8 * kGroupBlock);
  for (std::size_t k = 0; k < blocks; ++k) {
    const wide::Measure& m = measured_[k];
    if (!(m.worst <= r.absolute)) r.absolute = m.worst;  // keeps NaN
    r.typical_velocity = std::max(r.typical_velocity, m.typical);
    operand = std::max(operand, m.operand);
  }
  if (r.absolute != 0.0) {
    r.natural_map = r.typical_velocity > 0.0 ? r.absolute / r.typical_velocity
                                             : std::numeric_limits<double>::infinity();
  }
  if (r.typical_velocity > 0.0) r.floor = 16.0 * kEpsilon * operand / r.typical_velocity;
  return r;
}

}  // namespace rb
