#include "collision/epa.hpp"

#include <utility>

namespace rb {

bool ExpandingPolytope::add_face(int a, int b, int c) {
  Face face;
  face.vertex = {a, b, c};
  face.neighbor = {-1, -1, -1};
  const Vec3 ab = points_[b] - points_[a], ac = points_[c] - points_[a];
  const Vec3 cross = ab.cross(ac);
  const double area_sq = cross.squaredNorm();
  if (!(area_sq > 1e-26 * ab.squaredNorm() * ac.squaredNorm())) return false;
  face.normal = cross / std::sqrt(area_sq);
  face.distance = face.normal.dot(points_[a]);
  faces_.push_back(face);
  return true;
}

bool ExpandingPolytope::start(const std::array<Vec3, 4>& w) {
  points_.assign(w.begin(), w.end());
  faces_.clear();
  const Vec3 e1 = w[1] - w[0], e2 = w[2] - w[0], e3 = w[3] - w[0];
  const double volume = e1.cross(e2).dot(e3);
  if (!(std::abs(volume) >
        1e-13 * std::sqrt(e1.squaredNorm() * e2.squaredNorm() * e3.squaredNorm()))) {
    return false;
  }
  if (volume > 0.0) std::swap(points_[1], points_[2]);  // now 3 lies inside of (0, 1, 2)
  static constexpr int corner[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
  static constexpr int across[4][3] = {{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}};
  for (int f = 0; f < 4; ++f) {
    if (!add_face(corner[f][0], corner[f][1], corner[f][2])) return false;
    faces_.back().neighbor = {across[f][0], across[f][1], across[f][2]};
  }
  return true;
}

int ExpandingPolytope::nearest() const {
  int best = -1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    if (!faces_[f].alive || !(faces_[f].distance < least)) continue;
    least = faces_[f].distance;
    best = static_cast<int>(f);
  }
  return best;
}

bool ExpandingPolytope::expand(int start_face, const Vec3& w) {
  const int eye = static_cast<int>(points_.size());
  points_.push_back(w);
  horizon_.clear();
  stack_.assign(1, start_face);
  faces_[start_face].alive = false;
  while (!stack_.empty()) {
    const int f = stack_.back();
    stack_.pop_back();
    for (int e = 0; e < 3; ++e) {
      const int g = faces_[f].neighbor[e];
      Face& other = faces_[g];
      if (!other.alive) continue;
      if (other.normal.dot(w) - other.distance > 0.0) {
        other.alive = false;
        stack_.push_back(g);
      }
    }
    // Edges toward faces that stay are gathered afterwards, when all that go are known.
    horizon_.push_back({f, 0, 0, 0});
  }
  std::vector<HorizonEdge>& gone = horizon_;
  const std::size_t count = gone.size();
  for (std::size_t i = 0; i < count; ++i) {
    const int f = gone[i].tail;
    for (int e = 0; e < 3; ++e) {
      const int g = faces_[f].neighbor[e];
      if (!faces_[g].alive) continue;
      int slot = 0;
      while (slot < 3 && faces_[g].neighbor[slot] != f) ++slot;
      if (slot == 3) return false;
      gone.push_back({faces_[f].vertex[e], faces_[f].vertex[(e + 1) % 3], g, slot});
    }
  }
  gone.erase(gone.begin(), gone.begin() + static_cast<std::ptrdiff_t>(count));
  const std::size_t first = faces_.size();
  for (const HorizonEdge& edge : gone) {
    if (!add_face(edge.tail, edge.head, eye)) return false;
    faces_.back().neighbor = {edge.face, -1, -1};
    faces_[edge.face].neighbor[edge.slot] = static_cast<int>(faces_.size()) - 1;
  }
  for (std::size_t f = first; f < faces_.size(); ++f) {
    for (std::size_t g = first; g < faces_.size(); ++g) {
      if (faces_[g].vertex[0] != faces_[f].vertex[1]) continue;
      faces_[f].neighbor[1] = static_cast<int>(g);
      faces_[g].neighbor[2] = static_cast<int>(f);
    }
  }
  for (std::size_t f = first; f < faces_.size(); ++f) {
    if (faces_[f].neighbor[1] < 0 || faces_[f].neighbor[2] < 0) return false;
  }
  return faces_.size() > first;
}

}  // namespace rb
