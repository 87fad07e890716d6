#include <limits>
#include <vector>

#include "collision/polytope_polytope.hpp"
#include "math/tolerances.hpp"

namespace rb {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

Vec3 direction(const Polytope& p, const HullEdge& edge) {
  return p.vertex(edge.head) - p.vertex(edge.tail);
}

// slopes[f * edges + e] = (normal of face f of p) . (direction of edge e of q)
void face_edge_slopes(const Polytope& p, const std::vector<Vec3>& directions,
                      std::vector<double>& slopes) {
  const int edges = static_cast<int>(directions.size());
  slopes.resize(static_cast<std::size_t>(p.face_count()) * edges);
  for (int f = 0; f < p.face_count(); ++f) {
    const Vec3 n = p.normal(f);
    double* row = slopes.data() + static_cast<std::size_t>(f) * edges;
    for (int e = 0; e < edges; ++e) row[e] = n.dot(directions[e]);
  }
}

}  // namespace

PolytopeAxis separating_axis(const Polytope& a, const Polytope& b, double preference) {
  PolytopeAxis best;
  best.separation = -infinity;
  const auto wins = [&](double separation) { return separation > best.separation + preference; };
  for (int f = 0; f < b.face_count(); ++f) {
    const Vec3 n = b.normal(f);
    const double separation = b.height(f, a.vertex(a.farthest(-n)));
    if (wins(separation)) best = {PolytopeAxis::FACE_B, separation, n, 0, f};
  }
  for (int f = 0; f < a.face_count(); ++f) {
    const Vec3 n = a.normal(f);
    const double separation = a.height(f, b.vertex(b.farthest(-n)));
    if (wins(separation)) best = {PolytopeAxis::FACE_A, separation, -n, f, 0};
  }

  static thread_local std::vector<Vec3> along_a, along_b;
  static thread_local std::vector<double> slope_ab, slope_ba;
  const auto& edges_a = a.topology().edges;
  const auto& edges_b = b.topology().edges;
  along_a.clear();
  along_b.clear();
  for (const HullEdge& e : edges_a) along_a.push_back(direction(a, e));
  for (const HullEdge& e : edges_b) along_b.push_back(direction(b, e));
  face_edge_slopes(a, along_b, slope_ab);
  face_edge_slopes(b, along_a, slope_ba);
  const std::size_t count_a = edges_a.size(), count_b = edges_b.size();
  for (std::size_t i = 0; i < count_a; ++i) {
    const HullEdge& ea = edges_a[i];
    const double* left_row = slope_ab.data() + ea.left * count_b;
    const double* right_row = slope_ab.data() + ea.right * count_b;
    for (std::size_t j = 0; j < count_b; ++j) {
      // Arcs of the two edges cross on the Gauss map of A and that of -B.
      if (!(left_row[j] * right_row[j] < 0.0)) continue;
      const HullEdge& eb = edges_b[j];
      const double left_b = slope_ba[eb.left * count_a + i];
      const double right_b = slope_ba[eb.right * count_a + i];
      if (!(left_b * right_b < 0.0) || !(left_b * right_row[j] < 0.0)) continue;
      const Vec3 cross = along_a[i].cross(along_b[j]);
      const double length_sq = cross.squaredNorm();
      if (length_sq <= tolerance::parallel_edges * tolerance::parallel_edges *
                           along_a[i].squaredNorm() * along_b[j].squaredNorm()) {
        continue;
      }
      Vec3 n = cross / std::sqrt(length_sq);
      if (n.dot(a.normal(ea.left) + a.normal(ea.right)) > 0.0) n = -n;
      double separation = n.dot(a.vertex(ea.tail) - b.vertex(eb.tail));
      if (!wins(separation)) continue;
      // Beside sliver faces, whose normals are rounding, edges seem to meet that don't.
      separation = n.dot(a.vertex(a.farthest(-n, ea.tail)) - b.vertex(b.farthest(n, eb.tail)));
      if (wins(separation)) {
        best = {PolytopeAxis::EDGES, separation, n, static_cast<int>(i), static_cast<int>(j)};
      }
    }
  }
  return best;
}

}  // namespace rb
