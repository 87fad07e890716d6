#include "shape/hull_topology.hpp"

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

namespace rb {

namespace {

using Wide = __int128;
using GridPoint = std::array<std::int64_t, 3>;

constexpr double grid_steps =
    274877906944.0;                       // 2^38: three differences of 39 bits multiply exactly
constexpr double least_thickness = 1e-6;  // of the extent
constexpr int none = -1;

// Six times the signed volume of (a, b, c, d): positive when d lies outside of triangle a, b, c.
Wide orientation(const GridPoint& a, const GridPoint& b, const GridPoint& c, const GridPoint& d) {
  Wide u[3], v[3], w[3];
  for (int k = 0; k < 3; ++k) {
    u[k] = b[k] - a[k];
    v[k] = c[k] - a[k];
    w[k] = d[k] - a[k];
  }
  return (u[1] * v[2] - u[2] * v[1]) * w[0] + (u[2] * v[0] - u[0] * v[2]) * w[1] +
         (u[0] * v[1] - u[1] * v[0]) * w[2];
}

struct Facet {
  std::array<int, 3> vertex;
  std::array<int, 3> neighbor{none, none, none};
  std::vector<int> outside;  // points that see this facet, each kept by one facet only
  int visited = none;        // the point whose horizon search came by last
  bool visible = false;
  bool alive = true;
};

class Quickhull {
 public:
  explicit Quickhull(const std::vector<Vec3>& points) {
    Vec3 lower = points[0], upper = points[0];
    for (const Vec3& p : points) {
      lower = lower.cwiseMin(p);
      upper = upper.cwiseMax(p);
    }
    const Vec3 middle = 0.5 * (lower + upper);
    const double half = 0.5 * (upper - lower).maxCoeff();
    grid_.reserve(points.size());
    for (const Vec3& p : points) {
      const Vec3 scaled = (p - middle) / half * grid_steps;
      grid_.push_back({static_cast<std::int64_t>(std::nearbyint(scaled.x())),
                       static_cast<std::int64_t>(std::nearbyint(scaled.y())),
                       static_cast<std::int64_t>(std::nearbyint(scaled.z()))});
    }
  }

  std::vector<HullTriangle> run() {
    start();
    for (std::size_t f = 0; f < facets_.size(); ++f) {
      while (facets_[f].alive && !facets_[f].outside.empty()) add_farthest(static_cast<int>(f));
    }
    return triangles();
  }

 private:
  Vec3 at(int i) const {
    return {static_cast<double>(grid_[i][0]), static_cast<double>(grid_[i][1]),
            static_cast<double>(grid_[i][2])};
  }
  Wide side(const Facet& f, int point) const {
    return orientation(grid_[f.vertex[0]], grid_[f.vertex[1]], grid_[f.vertex[2]], grid_[point]);
  }

  template <class Measure>
  int farthest(const Measure& measure) const {
    int best = 0;
    double most = -1.0;
    for (int i = 0; i < static_cast<int>(grid_.size()); ++i) {
      const double m = measure(at(i));
      if (m > most) {
        most = m;
        best = i;
      }
    }
    return best;
  }

  // A first tetrahedron, as large as three greedy choices make it.
  void start() {
    const double extent = 2.0 * grid_steps;
    const Vec3 first = at(0);
    const int a = farthest([&](const Vec3& p) { return (p - first).squaredNorm(); });
    const Vec3 pa = at(a);
    const int b = farthest([&](const Vec3& p) { return (p - pa).squaredNorm(); });
    const Vec3 along = (at(b) - pa).normalized();
    const int c = farthest([&](const Vec3& p) { return (p - pa).cross(along).squaredNorm(); });
    if (!((at(c) - pa).cross(along).norm() > least_thickness * extent)) {
      throw std::invalid_argument(
          "the points of the hull lie on a line (within 1e-6 of their extent); a hull needs "
          "volume");
    }
    const Vec3 normal = (at(b) - pa).cross(at(c) - pa).normalized();
    const int d = farthest([&](const Vec3& p) { return std::abs(normal.dot(p - pa)); });
    if (!(std::abs(normal.dot(at(d) - pa)) > least_thickness * extent)) {
      throw std::invalid_argument(
          "the points of the hull lie in a plane (within 1e-6 of their extent); give the plate a "
          "thickness, or use a box");
    }
    std::array<int, 4> t{a, b, c, d};
    if (orientation(grid_[a], grid_[b], grid_[c], grid_[d]) > 0) std::swap(t[1], t[2]);
    // Now d lies inside of (a, b, c).
    const int corners[4][3] = {
        {t[0], t[1], t[2]}, {t[0], t[3], t[1]}, {t[1], t[3], t[2]}, {t[2], t[3], t[0]}};
    const int across[4][3] = {{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}};
    for (int f = 0; f < 4; ++f) {
      Facet facet;
      facet.vertex = {corners[f][0], corners[f][1], corners[f][2]};
      facet.neighbor = {across[f][0], across[f][1], across[f][2]};
      facets_.push_back(std::move(facet));
    }
    std::vector<int> all;
    for (int i = 0; i < static_cast<int>(grid_.size()); ++i) all.push_back(i);
    hand_out(all, 0);
  }

  // Gives every point to the first facet from `first_facet` on that it sees.
  void hand_out(const std::vector<int>& points, std::size_t first_facet) {
    for (const int p : points) {
      for (std::size_t f = first_facet; f < facets_.size(); ++f) {
        if (facets_[f].alive && side(facets_[f], p) > 0) {
          facets_[f].outside.push_back(p);
          break;
        }
      }
    }
  }

  struct HorizonEdge {
    int tail, head;  // as the hidden facet's neighbour had them
    int facet;       // the facet that stays
    int slot;        // its edge
  };

  void add_farthest(int start_facet) {
    const Facet& from = facets_[start_facet];
    int eye = from.outside[0];
    Wide most = 0;
    for (const int p : from.outside) {
      const Wide s = side(from, p);
      if (s > most) {
        most = s;
        eye = p;
      }
    }
    // Everything the eye sees goes; the rim of it, the horizon, is joined to the eye.
    std::vector<int> stack{start_facet}, seen{start_facet};
    facets_[start_facet].visited = eye;
    facets_[start_facet].visible = true;
    std::vector<HorizonEdge> horizon;
    while (!stack.empty()) {
      const int f = stack.back();
      stack.pop_back();
      for (int e = 0; e < 3; ++e) {
        const int g = facets_[f].neighbor[e];
        Facet& other = facets_[g];
        if (other.visited != eye) {
          other.visited = eye;
          other.visible = side(other, eye) > 0;
          if (other.visible) {
            stack.push_back(g);
            seen.push_back(g);
          }
        }
        if (other.visible) continue;
        const int tail = facets_[f].vertex[e], head = facets_[f].vertex[(e + 1) % 3];
        int slot = 0;
        while (other.vertex[slot] != head) ++slot;
        horizon.push_back({tail, head, g, slot});
      }
    }
    const std::size_t first_new = facets_.size();
    for (const HorizonEdge& edge : horizon) {
      Facet facet;
      facet.vertex = {edge.tail, edge.head, eye};
      facet.neighbor[0] = edge.facet;
      facets_[edge.facet].neighbor[edge.slot] = static_cast<int>(facets_.size());
      facets_.push_back(std::move(facet));
    }
    // Around the eye: the facet on head -> eye meets the one that starts at that head.
    for (std::size_t f = first_new; f < facets_.size(); ++f) {
      for (std::size_t g = first_new; g < facets_.size(); ++g) {
        if (facets_[g].vertex[0] != facets_[f].vertex[1]) continue;
        facets_[f].neighbor[1] = static_cast<int>(g);
        facets_[g].neighbor[2] = static_cast<int>(f);
      }
    }
    std::vector<int> orphans;
    for (const int f : seen) {
      facets_[f].alive = false;
      for (const int p : facets_[f].outside) {
        if (p != eye) orphans.push_back(p);
      }
      facets_[f].outside.clear();
    }
    hand_out(orphans, first_new);
  }

  std::vector<HullTriangle> triangles() const {
    std::vector<int> number(facets_.size(), none);
    int count = 0;
    for (std::size_t f = 0; f < facets_.size(); ++f) {
      if (facets_[f].alive) number[f] = count++;
    }
    std::vector<HullTriangle> out;
    out.reserve(count);
    for (const Facet& f : facets_) {
      if (!f.alive) continue;
      out.push_back(
          {f.vertex, {number[f.neighbor[0]], number[f.neighbor[1]], number[f.neighbor[2]]}});
    }
    return out;
  }

  std::vector<GridPoint> grid_;
  std::vector<Facet> facets_;
};

}  // namespace

std::vector<HullTriangle> hull_triangles(const std::vector<Vec3>& points) {
  if (points.size() < 4) {
    throw std::invalid_argument("a hull needs at least 4 points that span a volume, not " +
                                std::to_string(points.size()));
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) {
      throw std::invalid_argument("point " + std::to_string(i) + " of the hull is not finite");
    }
  }
  return Quickhull(points).run();
}

}  // namespace rb
