#include "world/group_balance.hpp"

#include <cmath>

#include "math/rotation.hpp"
#include "world/world.hpp"

namespace rb {

namespace {

constexpr double rounding = 1e-15;  // of a group's energy

bool turns(const Body& body) { return !body.inertia.inv_body.isZero(0.0); }

Mat3 world_inertia(const Body& body) {
  if (!turns(body)) return Mat3::Zero();
  const Mat3 r = body.state.q.toRotationMatrix();
  return r * body.inertia.body * r.transpose();
}

// One group: `order` lists its bodies, a parent before its children; the first one's link is that
// to what is immovable, or -1.
class Group {
 public:
  Group(World& world, std::span<const std::int32_t> rows, std::vector<Contact>& contacts,
        GroupWorkspace& work, std::span<const std::int32_t> order)
      : world_(world), rows_(rows), contacts_(contacts), work_(work), order_(order) {
    for (const std::int32_t k : order_) {
      mass_ += body(k).inertia.mass;
      center_ += body(k).inertia.mass * body(k).state.x;
      velocity_ += body(k).state.p;
    }
    center_ /= mass_;
    velocity_ /= mass_;
  }

  bool is_free() const { return work_.link[order_.front()] < 0; }

  // Both return what the kinetic energy gained, J.
  double return_angular_momentum(const Vec3& gain) {
    const Mat3 inertia = inertia_about_center();
    if (!(inertia.determinant() > 0.0)) return 0.0;
    const Vec3 turn = -(inertia.inverse() * gain);
    return change(
        [&](const Body& b, Vec3& p, Vec3& l) {
          p = b.inertia.mass * turn.cross(b.state.x - center_);
          l = world_inertia(b) * turn;
        },
        -gain);
  }

  // What moves against the rigid motion of the group (or against `anchor`, m/s).
  double slow_down(double gain, const Vec3& anchor) {
    Vec3 carry = anchor, turn = Vec3::Zero();
    if (is_free()) {
      carry = velocity_;
      Vec3 momentum = Vec3::Zero();
      for (const std::int32_t k : order_) {
        const Body& b = body(k);
        momentum += b.state.L + (b.state.x - center_).cross(b.state.p - b.inertia.mass * carry);
      }
      const Mat3 inertia = inertia_about_center();
      if (inertia.determinant() > 0.0) turn = inertia.inverse() * momentum;
    }
    const auto inner_p = [&](const Body& b) -> Vec3 {
      return b.state.p - b.inertia.mass * (carry + turn.cross(b.state.x - center_));
    };
    const auto inner_l = [&](const Body& b) -> Vec3 {
      return turns(b) ? Vec3(b.state.L - world_inertia(b) * turn) : Vec3::Zero();
    };
    double inner = 0.0, all = 0.0;  // J
    for (const std::int32_t k : order_) {
      const Body& b = body(k);
      const Vec3 p = inner_p(b), l = inner_l(b), w = b.angular_velocity();
      inner += 0.5 * (b.inertia.inv_mass * p.squaredNorm() + l.dot(turns(b) ? Vec3(w - turn) : w));
      all +=
          0.5 * (b.inertia.mass * (b.linear_velocity() - carry).squaredNorm() + w.dot(b.state.L));
    }
    if (!(gain > rounding * all) || !(inner > 0.0)) return 0.0;
    const double share = gain / inner;
    // 1 - sqrt(1 - share), to the digits of a small share.
    const double less = share < 1.0 ? share / (1.0 + std::sqrt(1.0 - share)) : 1.0;
    return change([&](const Body& b, Vec3& p, Vec3& l) {
      p = -less * inner_p(b);
      l = -less * inner_l(b);
    });
  }

 private:
  Body& body(std::int32_t k) const { return world_.bodies[rows_[k]]; }

  Mat3 inertia_about_center() const {
    Mat3 sum = Mat3::Zero();
    Vec3 line = Vec3::Zero();
    bool points = true;
    for (const std::int32_t k : order_) {
      const Body& b = body(k);
      const Vec3 d = b.state.x - center_;
      sum += world_inertia(b) +
             b.inertia.mass * (d.squaredNorm() * Mat3::Identity() - d * d.transpose());
      points &= !turns(b);
      if (d.squaredNorm() > line.squaredNorm()) line = d;
    }
    // Points in a line turn about no axis along it, and owe nothing about it.
    const double size = sum.trace();
    if (points && sum.determinant() <= 1e-12 * size * size * size)
      sum += size / line.squaredNorm() * line * line.transpose();
    return sum;
  }

  // Applies the changes of momenta that `of` gives for each body and books them: each link carries
  // what the bodies behind it need. `angular`: what they make of the angular momentum of a free
  // group.
  template <class Of>
  double change(Of&& of, const Vec3& angular = Vec3::Zero()) {
    std::vector<Vec3>&impulse = work_.impulse, &moment = work_.moment;
    double gain = 0.0;
    for (const std::int32_t k : order_) {
      Body& b = body(k);
      of(b, impulse[k], moment[k]);
    }
    for (const std::int32_t k : order_) {
      Body& b = body(k);
      const Vec3 v = b.linear_velocity(), w = b.angular_velocity();
      b.state.p += impulse[k];
      b.state.L += moment[k];
      gain +=
          0.5 * (impulse[k].dot(v + b.linear_velocity()) + moment[k].dot(w + b.angular_velocity()));
    }
    for (std::size_t n = order_.size(); n-- > 0;) {
      const std::int32_t k = order_[n];
      const std::int32_t i = work_.link[k];
      if (i < 0) {
        // Free: but for rounding, which goes, nothing is left to book but what a displacement made.
        body(k).state.p -= impulse[k];
        body(k).state.L -= moment[k] - angular;
        Contact& c = contacts_[work_.link[order_[1]]];
        (c.body_a == rows_[k] ? c.moment_a : c.moment_b) += angular;
        continue;
      }
      Contact& c = contacts_[i];
      const bool is_a = c.body_a == rows_[k];
      const Body& other = world_.bodies[is_a ? c.body_b : c.body_a];
      // On the other body, about its centre.
      const Vec3 back = -moment[k] - (body(k).state.x - other.state.x).cross(impulse[k]);
      c.impulse += is_a ? impulse[k] : Vec3(-impulse[k]);
      (is_a ? c.moment_a : c.moment_b) += moment[k];
      (is_a ? c.moment_b : c.moment_a) += back;
      const std::int32_t up = work_.parent[k];
      if (up < 0) continue;
      impulse[up] += impulse[k];
      moment[up] -= back;
    }
    return gain;
  }

  World& world_;
  std::span<const std::int32_t> rows_;
  std::vector<Contact>& contacts_;
  GroupWorkspace& work_;
  std::span<const std::int32_t> order_;
  double mass_ = 0.0;                                     // kg
  Vec3 center_ = Vec3::Zero(), velocity_ = Vec3::Zero();  // m, m/s
};

// Lists in work.order, from `begin` on, what the links reach from there, a parent before its
// children.
void reach_out(const World& world, const std::vector<Contact>& contacts, GroupWorkspace& work,
               std::size_t begin) {
  const auto index = [&](std::int32_t row) {
    return world.bodies[row].is_dynamic() ? world.work.index_of[row] : -1;
  };
  for (std::size_t n = begin; n < work.order.size(); ++n) {
    const std::int32_t k = work.order[n];
    for (std::int32_t at = work.first[k]; at < work.first[k + 1]; ++at) {
      const std::int32_t i = work.next[at];
      const std::int32_t a = index(contacts[i].body_a), b = index(contacts[i].body_b);
      const std::int32_t to = a == k ? b : a;
      if (to < 0 || work.listed[to]) continue;
      work.listed[to] = 1;
      work.parent[to] = k;
      work.link[to] = i;
      work.order.push_back(to);
    }
  }
}

}  // namespace

void take_back_gains(World& world, std::span<const std::int32_t> rows,
                     std::vector<Contact>& contacts, std::span<const std::int32_t> links,
                     std::span<const BodyGain> gains, const Vec3& reference, GroupWorkspace& work) {
  const std::size_t nb = rows.size();
  const std::vector<std::int32_t>& index_of = world.work.index_of;
  work.first.assign(nb + 2, 0);
  work.parent.assign(nb, -1);
  work.link.assign(nb, -1);
  work.listed.assign(nb, 0);
  work.impulse.resize(nb);
  work.moment.resize(nb);
  const auto each_end = [&](const auto& visit) {
    for (const std::int32_t i : links) {
      const Contact& c = contacts[i];
      visit(i, index_of[c.body_a]);
      if (world.bodies[c.body_b].is_dynamic()) visit(i, index_of[c.body_b]);
    }
  };
  each_end([&](std::int32_t, std::int32_t k) { ++work.first[k + 2]; });
  for (std::size_t k = 2; k < work.first.size(); ++k) work.first[k] += work.first[k - 1];
  work.next.resize(work.first.back());
  each_end([&](std::int32_t i, std::int32_t k) { work.next[work.first[k + 1]++] = i; });

  for (std::size_t start = 0; start < nb; ++start) {
    if (work.listed[start] || work.first[start] == work.first[start + 1]) continue;
    work.order.assign(1, static_cast<std::int32_t>(start));
    work.listed[start] = 1;
    reach_out(world, contacts, work, 0);
    // Once more from what meets something immovable: that is where momentum goes.
    work.members = work.order;
    const Body* anchor = nullptr;
    bool one_frame = true;
    work.order.clear();
    for (const std::int32_t k : work.members) work.listed[k] = 0;
    for (const std::int32_t k : work.members) {
      for (std::int32_t at = work.first[k]; at < work.first[k + 1]; ++at) {
        const Body& b = world.bodies[contacts[work.next[at]].body_b];
        if (b.is_dynamic()) continue;
        one_frame &= b.spin.isZero(0.0) && (!anchor || anchor->velocity == b.velocity);
        anchor = &b;
        if (work.listed[k]) continue;
        work.listed[k] = 1;
        work.parent[k] = -1;
        work.link[k] = work.next[at];
        work.order.push_back(k);
      }
    }
    if (!anchor) {
      work.order.assign(1, work.members.front());
      work.listed[work.members.front()] = 1;
      work.parent[work.members.front()] = work.link[work.members.front()] = -1;
    }
    reach_out(world, contacts, work, 0);
    const Vec3 frame = anchor ? anchor->velocity : reference;
    double energy = 0.0;
    Vec3 angular = Vec3::Zero();
    for (const std::int32_t k : work.order) {
      energy += gains[k].energy - gains[k].impulse.dot(frame - reference);
      angular += gains[k].angular;
    }
    Group group(world, rows, contacts, work, work.order);
    if (!anchor && !angular.isZero(0.0)) energy += group.return_angular_momentum(angular);
    if (one_frame && energy > 0.0) group.slow_down(energy, frame);
  }
}

}  // namespace rb
