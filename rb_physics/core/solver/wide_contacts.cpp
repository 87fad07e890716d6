#include "solver/wide_contacts.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "solver/wide_level.hpp"

namespace rb {
namespace {

constexpr int kLanes = wide::kLanes;
constexpr std::int32_t kFewGroups = 4;     // are not worth another thread
constexpr std::size_t kFewContacts = 128;  // nor are these
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

// Cuts the groups of every colour into as many parts of about the same count of slots as there are
// threads. A part has about the same bodies in every colour.
void WideContacts::cut_colours() {
  parts_ = crew_ != nullptr ? crew_->threads() : 1;
  cuts_.clear();
  for (std::size_t c = 0; c + 1 < colour_begin_.size(); ++c) {
    const std::int32_t first = colour_begin_[c], end = colour_begin_[c + 1];
    const std::int32_t slots_begin = groups_[first].slot;
    const std::int32_t slots = groups_[end - 1].slot + groups_[end - 1].slots - slots_begin;
    std::int32_t g = first;
    for (std::int64_t k = 0; k < parts_; ++k) {
      while (g < end && (groups_[g].slot - slots_begin) * std::int64_t{parts_} < k * slots) ++g;
      cuts_.push_back(g);
    }
    cuts_.push_back(end);
  }
}

// call(begin, end) of groups: colour after colour, the groups of one shared.
template <class Call>
void WideContacts::for_colours(const Call& call) {
  for (std::size_t c = 0; c + 1 < colour_begin_.size(); ++c) {
    const std::int32_t first = colour_begin_[c], end = colour_begin_[c + 1];
    if (parts_ == 1 || end - first < kFewGroups) {
      call(first, end);
      continue;
    }
    const std::int32_t* cut = &cuts_[c * static_cast<std::size_t>(parts_ + 1)];
    crew_->share(parts_, [&](int, std::int32_t k) { call(cut[k], cut[k + 1]); });
  }
}

// call(part, colour, begin, end) of all groups, which must not depend on each other. Results per
// part may depend on the count of threads.
template <class Call>
void WideContacts::for_parts(const Call& call) {
  const auto all_of = [&](std::int32_t k) {
    for (std::size_t c = 0; c + 1 < colour_begin_.size(); ++c) {
      const std::int32_t* cut = &cuts_[c * static_cast<std::size_t>(parts_ + 1)];
      if (cut[k] < cut[k + 1]) call(k, c, cut[k], cut[k + 1]);
    }
  };
  if (parts_ == 1) return all_of(0);
  crew_->share(parts_, [&](int, std::int32_t k) { all_of(k); });
}

// Elements of `impulse_` that belong to these groups.
std::pair<std::int64_t, std::int64_t> WideContacts::impulses_of(std::int32_t begin,
                                                                std::int32_t end) const {
  constexpr std::int64_t per_slot = 3 * kLanes;
  const wide::Group& last = groups_[end - 1];
  return {per_slot * groups_[begin].slot, per_slot * (last.slot + last.slots)};
}

void WideContacts::load(const ContactProblem& problem, const std::vector<FrictionCone>& cones) {
  if (!begun_) make_groups(problem, crew_);
  begun_ = false;
  frictionless_ =
      std::all_of(cones.begin(), cones.end(), [](const auto& c) { return c.slide == 0.0; });
  fill(problem, &cones, true);
}

void WideContacts::load_frictionless(const ContactProblem& problem) {
  make_groups(problem, crew_);
  frictionless_ = true;
  fill(problem, nullptr, true);
}

void WideContacts::reload_frictionless(const ContactProblem& problem) {
  frictionless_ = true;
  fill(problem, nullptr, false);
}

void WideContacts::fill_group(const ContactProblem& problem, const std::vector<FrictionCone>* cones,
                              std::size_t colour, std::int32_t group_index) {
  const std::vector<PointRange>& manifolds = colours_.manifolds();
  wide::Group& group = groups_[group_index];
  double* rows = manifolds_.data() + kLanes * static_cast<std::size_t>(group.manifold);
  double* slots = points_.data() + static_cast<std::size_t>(group.slot) * wide::kSlotRows * kLanes;
  std::memset(rows, 0, sizeof(double) * wide::kManifoldRows * kLanes);
  std::memset(slots, 0, sizeof(double) * wide::kSlotRows * kLanes * group.slots);
  const auto c = static_cast<int>(colour);
  const std::int32_t first = colours_.begin(c) + (group_index - colour_begin_[colour]) * kLanes;
  const int lanes = std::min(kLanes, colours_.begin(c + 1) - first);
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

// What may have changed since the group was filled, and no friction.
void WideContacts::refill_group(const ContactProblem& problem, std::size_t colour,
                                std::int32_t group_index) {
  const std::vector<PointRange>& manifolds = colours_.manifolds();
  const wide::Group& group = groups_[group_index];
  const auto c = static_cast<int>(colour);
  const std::int32_t first = colours_.begin(c) + (group_index - colour_begin_[colour]) * kLanes;
  const int lanes = std::min(kLanes, colours_.begin(c + 1) - first);
  double* rows = manifolds_.data() + kLanes * static_cast<std::size_t>(group.manifold);
  double* slots = points_.data() + static_cast<std::size_t>(group.slot) * wide::kSlotRows * kLanes;
  for (int lane = 0; lane < lanes; ++lane) {
    const PointRange& range = manifolds[first + lane];
    double* m = rows + lane;
    put_symmetric(m + kLanes * wide::kInertiaA, problem.inv_inertia[group.a[lane]]);
    if (group.b[lane] != nobody_) {
      put_symmetric(m + kLanes * wide::kInertiaB, problem.inv_inertia[group.b[lane]]);
    }
    for (std::int32_t j = 0; j < range.count; ++j) {
      double* p = slots + j * wide::kSlotRows * kLanes + lane;
      put_vector(p + kLanes * wide::kBias, problem.contacts[range.first + j].bias);
      p[kLanes * wide::kFriction] = 0.0;
    }
  }
}

void WideContacts::make_groups(const ContactProblem& problem, Crew* crew) {
  kernel_ = &wide::chosen_kernel();
  colours_.build(problem, crew);
  const std::vector<PointRange>& manifolds = colours_.manifolds();
  groups_.clear();
  colour_begin_.clear();
  nobody_ = static_cast<std::int32_t>(problem.inv_mass.size());
  std::int32_t slots = 0;
  for (int c = 0; c < colours_.colour_count(); ++c) {
    colour_begin_.push_back(static_cast<std::int32_t>(groups_.size()));
    for (std::int32_t k = colours_.begin(c); k < colours_.begin(c + 1); k += kLanes) {
      wide::Group group;
      group.slots = 0;
      for (std::int32_t m = k; m < std::min(k + kLanes, colours_.begin(c + 1)); ++m)
        group.slots = std::max(group.slots, manifolds[m].count);
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
  place_.resize(problem.contacts.size());
  partial_.resize(groups_.size());
  cut_colours();
}

void WideContacts::fill(const ContactProblem& problem, const std::vector<FrictionCone>* cones,
                        bool anew) {
  set_zero(free_);
  for (std::size_t b = 0; b < problem.velocity.size(); ++b) {
    std::copy_n(problem.velocity[b].data(), 6, free_.data() + 8 * b);
  }
  measured_.assign(parts_, wide::Measure{});
  for_parts([&](std::int32_t part, std::size_t colour, std::int32_t begin, std::int32_t end) {
    for (std::int32_t g = begin; g < end; ++g) {
      anew ? fill_group(problem, cones, colour, g) : refill_group(problem, colour, g);
    }
    kernel_->prepare(view(), begin, end);
    wide::Measure m;
    kernel_->measure_free(view(), begin, end, 16.0 * kEpsilon / 1e-9, &m);
    measured_[part].typical = std::max(measured_[part].typical, m.typical);
  });
  typical_free_ = 0.0;
  for (const wide::Measure& m : measured_) typical_free_ = std::max(typical_free_, m.typical);
}

void WideContacts::start_acceleration() {
  last_sq_ = 0.0;
  last_impulse_.resize(impulse_.size());
  last_velocity_.resize(velocity_.size());
  direction_.resize(impulse_.size());
  velocity_direction_.resize(velocity_.size());
  std::copy_n(velocity_.data(), velocity_.size(), last_velocity_.data());
  set_zero(velocity_direction_);
  for_parts([&](std::int32_t, std::size_t, std::int32_t begin, std::int32_t end) {
    const auto [first, last] = impulses_of(begin, end);
    std::copy(impulse_.data() + first, impulse_.data() + last, last_impulse_.data() + first);
    std::fill(direction_.data() + first, direction_.data() + last, 0.0);
  });
}

void WideContacts::clear_impulses() {
  for_parts([&](std::int32_t, std::size_t, std::int32_t begin, std::int32_t end) {
    const auto [first, last] = impulses_of(begin, end);
    std::fill(impulse_.data() + first, impulse_.data() + last, 0.0);
  });
  std::copy_n(free_.data(), free_.size(), velocity_.data());
  start_acceleration();
}

void WideContacts::set_impulses(const std::vector<Vec3>& impulse) {
  set_zero(impulse_);
  share_range(impulse.size(), kFewContacts, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) put_vector(impulse_.data() + place_[i], impulse[i]);
  });
  std::copy_n(free_.data(), free_.size(), velocity_.data());
  const wide::View s = view();
  for_colours([&](std::int32_t begin, std::int32_t end) { kernel_->apply(s, begin, end); });
  start_acceleration();
}

void WideContacts::impulses(std::vector<Vec3>& impulse) const {
  impulse.resize(place_.size());
  share_range(place_.size(), kFewContacts, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const double* p = impulse_.data() + place_[i];
      impulse[i] = Vec3(p[0], p[kLanes], p[2 * kLanes]);
    }
  });
}

void WideContacts::velocities(std::vector<Vec6>& v) const {
  v.resize(nobody_);
  for (std::int32_t b = 0; b < nobody_; ++b) {
    v[b] = Eigen::Map<const Vec6>(velocity_.data() + 8 * static_cast<std::size_t>(b));
  }
}

void WideContacts::accelerated_sweep(bool restart) {
  const wide::View s = view();
  const auto sweep = frictionless_ ? kernel_->sweep_frictionless : kernel_->sweep;
  for_colours([&](std::int32_t begin, std::int32_t end) {
    sweep(s, begin, end);
    for (std::int32_t g = begin; g < end; ++g) {
      const auto [first, last] = impulses_of(g, g + 1);
      partial_[g] = kernel_->difference_sq(impulse_.data(), last_impulse_.data(), first, last);
    }
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
  for_parts([&](std::int32_t, std::size_t, std::int32_t begin, std::int32_t end) {
    const auto [first, last] = impulses_of(begin, end);
    kernel_->extrapolate(impulse_.data(), last_impulse_.data(), direction_.data(), beta, first,
                         last);
  });
  share_range(velocity_.size() / 8, kFewContacts, [&](std::size_t begin, std::size_t end) {
    kernel_->extrapolate(velocity_.data(), last_velocity_.data(), velocity_direction_.data(), beta,
                         8 * static_cast<std::int64_t>(begin), 8 * static_cast<std::int64_t>(end));
  });
}

WideResidual WideContacts::measure() {
  const wide::View s = view();
  measured_.assign(parts_, wide::Measure{});
  const auto add = [](wide::Measure& sum, const wide::Measure& m) {
    if (!(m.worst <= sum.worst)) sum.worst = m.worst;  // keeps NaN
    sum.typical = std::max(sum.typical, m.typical);
    sum.operand = std::max(sum.operand, m.operand);
  };
  for_parts([&](std::int32_t part, std::size_t, std::int32_t begin, std::int32_t end) {
    wide::Measure m;
    kernel_->measure(s, begin, end, &m);
    add(measured_[part], m);
  });
  wide::Measure all{};
  for (const wide::Measure& m : measured_) add(all, m);
  WideResidual r;
  r.absolute = all.worst;
  r.typical_velocity = std::max(typical_free_, all.typical);
  const double operand = all.operand;
  if (r.absolute != 0.0) {
    r.natural_map = r.typical_velocity > 0.0 ? r.absolute / r.typical_velocity
                                             : std::numeric_limits<double>::infinity();
  }
  if (r.typical_velocity > 0.0) r.floor = 16.0 * kEpsilon * operand / r.typical_velocity;
  return r;
}

}  // namespace rb
