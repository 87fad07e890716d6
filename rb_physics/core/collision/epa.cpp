#include "collision/epa.hpp"

#include <limits>
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
  distances_.push_back(face.distance);
  return true;
}

bool ExpandingPolytope::start(const std::array<Vec3, 4>& w, const std::array<Origin, 4>& origins) {
  points_.assign(w.begin(), w.end());
  origins_.assign(origins.begin(), origins.end());
  after_.assign(4, -1);
  faces_.clear();
  distances_.clear();
  const Vec3 e1 = w[1] - w[0], e2 = w[2] - w[0], e3 = w[3] - w[0];
  const double volume = e1.cross(e2).dot(e3);
  if (!(std::abs(volume) >
        1e-13 * std::sqrt(e1.squaredNorm() * e2.squaredNorm() * e3.squaredNorm()))) {
    return false;
  }
  if (volume > 0.0) {  // now 3 lies inside of (0, 1, 2)
    std::swap(points_[1], points_[2]);
    std::swap(origins_[1], origins_[2]);
  }
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
  const int count = static_cast<int>(distances_.size());
  for (int f = 0; f < count; ++f) {
    if (!(distances_[f] < least)) continue;
    least = distances_[f];
    best = f;
  }
  return best;
}

bool ExpandingPolytope::expand(int start_face, const Vec3& w, const Origin& origin) {
  const auto remove = [this](int f) {
    faces_[f].alive = false;
    distances_[f] = std::numeric_limits<double>::infinity();
  };
  const int eye = static_cast<int>(points_.size());
  points_.push_back(w);
  origins_.push_back(origin);
  after_.push_back(-1);
  gone_.clear();
  stack_.assign(1, start_face);
  remove(start_face);
  while (!stack_.empty()) {
    const int f = stack_.back();
    stack_.pop_back();
    gone_.push_back(f);
    for (const int g : faces_[f].neighbor) {
      const Face& other = faces_[g];
      if (!other.alive || !(other.normal.dot(w) - other.distance > 0.0)) continue;
      remove(g);
      stack_.push_back(g);
    }
  }
  // The edges between faces that go and faces that stay.
  horizon_.clear();
  for (const int f : gone_) {
    for (int e = 0; e < 3; ++e) {
      const int g = faces_[f].neighbor[e];
      if (!faces_[g].alive) continue;
      int slot = 0;
      while (slot < 3 && faces_[g].neighbor[slot] != f) ++slot;
      if (slot == 3) return false;
      horizon_.push_back({faces_[f].vertex[e], faces_[f].vertex[(e + 1) % 3], g, slot});
    }
  }
  const int first = static_cast<int>(faces_.size());
  for (const HorizonEdge& edge : horizon_) {
    if (after_[edge.tail] >= first) return false;  // the horizon meets itself
    if (!add_face(edge.tail, edge.head, eye)) return false;
    const int f = static_cast<int>(faces_.size()) - 1;
    after_[edge.tail] = f;
    faces_[f].neighbor = {edge.face, -1, -1};
    faces_[edge.face].neighbor[edge.slot] = f;
  }
  const int last = static_cast<int>(faces_.size());
  for (int f = first; f < last; ++f) {
    const int next = after_[faces_[f].vertex[1]];
    if (next < first) return false;
    faces_[f].neighbor[1] = next;
    faces_[next].neighbor[2] = f;
  }
  for (int f = first; f < last; ++f) {
    if (faces_[f].neighbor[2] < 0) return false;
  }
  return last > first;
}

}  // namespace rb
