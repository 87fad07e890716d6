#include "solver/manifold_colours.hpp"

#include <algorithm>
#include <bit>

namespace rb {
namespace {

constexpr std::size_t kFewContacts = 256;  // are not worth another thread

bool same_manifold(const ContactConstraint& x, const ContactConstraint& y) {
  return x.a == y.a && x.b == y.b && (x.frame.array() == y.frame.array()).all();
}

}  // namespace

void ManifoldColours::build(const ContactProblem& problem, Crew* crew) {
  const std::vector<ContactConstraint>& contacts = problem.contacts;
  const auto nc = static_cast<std::int32_t>(contacts.size());
  const auto nb = static_cast<std::int32_t>(problem.inv_mass.size());
  head_.resize(contacts.size());
  const auto find_heads = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      head_[i] = i == 0 || !same_manifold(contacts[i - 1], contacts[i]);
    }
  };
  if (crew != nullptr) {
    crew->share_range(contacts.size(), kFewContacts, find_heads);
  } else {
    find_heads(0, contacts.size());
  }
  found_.clear();
  degree_.assign(nb, 0);
  for (std::int32_t i = 0; i < nc;) {
    PointRange m{i, 1, 0};
    while (i + m.count < nc && m.count < kMostPoints && !head_[i + m.count]) ++m.count;
    ++degree_[contacts[i].a];
    if (contacts[i].b >= 0) ++degree_[contacts[i].b];
    found_.push_back(m);
    i += m.count;
  }

  // A body with n manifolds may see colours up to twice the greatest degree.
  const std::int32_t most = nb > 0 ? *std::max_element(degree_.begin(), degree_.end()) : 0;
  const std::int32_t words = (2 * most + 63) / 64;
  taken_.assign(static_cast<std::size_t>(nb) * words, 0);
  int colours = 0;
  for (PointRange& m : found_) {
    const ContactConstraint& c = contacts[m.first];
    std::uint64_t* of_a = &taken_[static_cast<std::size_t>(c.a) * words];
    std::uint64_t* of_b = c.b < 0 ? nullptr : &taken_[static_cast<std::size_t>(c.b) * words];
    for (std::int32_t w = 0; w < words; ++w) {
      const std::uint64_t taken = of_a[w] | (of_b != nullptr ? of_b[w] : 0);
      if (taken == ~std::uint64_t{0}) continue;
      const int bit = std::countr_one(taken);
      of_a[w] |= std::uint64_t{1} << bit;
      if (of_b != nullptr) of_b[w] |= std::uint64_t{1} << bit;
      m.colour = 64 * w + bit;
      break;
    }
    colours = std::max(colours, m.colour + 1);
  }

  // By colour, region, more points first and in the next region last, so that neighbours in a group
  // have about as many; stable. A region has enough of each colour for that.
  constexpr int enough = 64;
  const int regions = std::clamp(static_cast<int>(found_.size()) / (enough * std::max(colours, 1)),
                                 1, kMostRegions);
  const int kinds = regions * (kMostPoints + 1);
  const auto key = [&](const PointRange& m) {
    const auto region = static_cast<int>(std::int64_t{regions} * contacts[m.first].a / nb);
    return m.colour * kinds + region * (kMostPoints + 1) +
           (region % 2 == 0 ? kMostPoints - m.count : m.count);
  };
  word_.assign(static_cast<std::size_t>(colours) * kinds + 1, 0);
  for (const PointRange& m : found_) ++word_[key(m) + 1];
  for (std::size_t k = 1; k < word_.size(); ++k) word_[k] += word_[k - 1];
  begin_.clear();
  for (int c = 0; c <= colours; ++c) begin_.push_back(word_[static_cast<std::size_t>(c) * kinds]);
  sorted_.resize(found_.size());
  for (const PointRange& m : found_) sorted_[word_[key(m)]++] = m;
}

}  // namespace rb
