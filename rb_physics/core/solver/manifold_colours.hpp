// Graph colouring of a contact problem: manifolds of one colour share no body that moves, so that
// they can be solved at the same time. Greedy in index order, a function of the problem alone.
#pragma once

#include <cstdint>
#include <vector>

#include "contact/problem.hpp"
#include "math/crew.hpp"

namespace rb {

// Consecutive contacts of one pair of bodies with one frame.
struct PointRange {
  std::int32_t first = 0;  // contact
  std::int32_t count = 0;
  std::int32_t colour = 0;
};

class ManifoldColours {
 public:
  static constexpr int kMostPoints = 8;   // longer runs are cut
  static constexpr int kMostRegions = 8;  // of bodies, by their index: threads keep to some

  // By the crew's threads, if there are any.
  void build(const ContactProblem& problem, Crew* crew);

  int colour_count() const { return static_cast<int>(begin_.size()) - 1; }
  // By colour; within one by the region of A, then more points first, then in the order of
  // contacts.
  const std::vector<PointRange>& manifolds() const { return sorted_; }
  // manifolds()[begin(c)] ... [begin(c + 1) - 1] have colour c.
  std::int32_t begin(int colour) const { return begin_[colour]; }

 private:
  std::vector<PointRange> found_, sorted_;
  std::vector<std::int32_t> begin_, degree_, word_;
  std::vector<std::uint8_t> head_;    // of a contact: it is the first of a manifold
  std::vector<std::uint64_t> taken_;  // colours at each body, 64 a word
};

}  // namespace rb
