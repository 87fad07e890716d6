#include "collision/simplex.hpp"

#include <cmath>
#include <limits>

namespace rb {

namespace {

// The face of a simplex nearest the origin: which vertices, with which weights, how far.
struct Nearest {
  int size = 0;
  std::array<int, 3> vertex{};
  std::array<double, 3> weight{};
  double distance_sq = std::numeric_limits<double>::infinity();
};

using Vertices = std::array<SimplexVertex, 4>;

Nearest nearest_vertex(const Vertices& v, int i) {
  return {1, {i, 0, 0}, {1.0, 0.0, 0.0}, v[i].w.squaredNorm()};
}

Nearest nearest_on_segment(const Vertices& v, int i, int j) {
  const Vec3 edge = v[j].w - v[i].w;
  const double along = -v[i].w.dot(edge);
  const double length_sq = edge.squaredNorm();
  if (!(along > 0.0)) return nearest_vertex(v, i);
  if (!(along < length_sq)) return nearest_vertex(v, j);
  const double t = along / length_sq;
  const Vec3 point = v[i].w + t * edge;
  return {2, {i, j, 0}, {1.0 - t, t, 0.0}, point.squaredNorm()};
}

const Nearest& nearer(const Nearest& a, const Nearest& b) {
  return b.distance_sq < a.distance_sq ? b : a;
}

Nearest nearest_on_triangle(const Vertices& v, int i, int j, int k) {
  const Vec3 ij = v[j].w - v[i].w, ik = v[k].w - v[i].w;
  const Vec3 normal = ij.cross(ik);
  const double area_sq = normal.squaredNorm();
  // Weights of the projected origin, as signed areas over the plane.
  const double wi = v[j].w.cross(v[k].w).dot(normal);
  const double wj = v[k].w.cross(v[i].w).dot(normal);
  const double wk = v[i].w.cross(v[j].w).dot(normal);
  if (wi > 0.0 && wj > 0.0 && wk > 0.0 && area_sq > 1e-28 * ij.squaredNorm() * ik.squaredNorm()) {
    const double sum = wi + wj + wk;
    const double height = v[i].w.dot(normal);
    return {3, {i, j, k}, {wi / sum, wj / sum, wk / sum}, height * height / area_sq};
  }
  return nearer(nearer(nearest_on_segment(v, i, j), nearest_on_segment(v, i, k)),
                nearest_on_segment(v, j, k));
}

}  // namespace

Vec3 Simplex::nearest() const {
  if (size == 3) {
    const Vec3 normal = (vertex[1].w - vertex[0].w).cross(vertex[2].w - vertex[0].w);
    return (normal.dot(vertex[0].w) / normal.squaredNorm()) * normal;
  }
  Vec3 sum = weight[0] * vertex[0].w;
  for (int i = 1; i < size; ++i) sum += weight[i] * vertex[i].w;
  if (size == 2) {
    const Vec3 edge = vertex[1].w - vertex[0].w;
    sum -= (edge.dot(sum) / edge.squaredNorm()) * edge;
  }
  return sum;
}

Simplex::Step Simplex::reduce_to_nearest(double distance_sq) {
  Nearest best;
  if (size == 1) {
    best = nearest_vertex(vertex, 0);
  } else if (size == 2) {
    best = nearest_on_segment(vertex, 0, 1);
  } else if (size == 3) {
    best = nearest_on_triangle(vertex, 0, 1, 2);
  } else {
    const Vec3 e1 = vertex[1].w - vertex[0].w, e2 = vertex[2].w - vertex[0].w,
               e3 = vertex[3].w - vertex[0].w;
    const double volume = e1.cross(e2).dot(e3);
    const double scale = std::sqrt(e1.squaredNorm() * e2.squaredNorm() * e3.squaredNorm());
    const bool flat = std::abs(volume) <= 1e-14 * scale;
    static constexpr int face[4][4] = {{1, 2, 3, 0}, {0, 2, 3, 1}, {0, 1, 3, 2}, {0, 1, 2, 3}};
    bool inside = true;
    for (const auto& f : face) {
      const Vec3& p = vertex[f[0]].w;
      const Vec3 normal = (vertex[f[1]].w - p).cross(vertex[f[2]].w - p);
      const double side_of_origin = -p.dot(normal);
      const double side_of_opposite = (vertex[f[3]].w - p).dot(normal);
      if (!flat && side_of_origin * side_of_opposite > 0.0) continue;
      inside = false;
      best = nearer(best, nearest_on_triangle(vertex, f[0], f[1], f[2]));
    }
    if (inside) return Step::INSIDE;
  }
  if (!(best.distance_sq < distance_sq)) {
    --size;
    return Step::STUCK;
  }
  // Kept vertices are in ascending order: moving them down overwrites none that is still needed.
  for (int i = 0; i < best.size; ++i) {
    if (best.vertex[i] != i) vertex[i] = vertex[best.vertex[i]];
    weight[i] = best.weight[i];
  }
  size = best.size;
  return Step::NEARER;
}

}  // namespace rb
