// Penetration depth of two convex sets by the expanding polytope algorithm (van den Bergen
// 2003, 4.3).
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "collision/gjk.hpp"
#include "math/types.hpp"

namespace rb {

// A convex polytope inside the Minkowski difference A - B that grows toward its boundary. Faces
// carry a signed distance, so that the origin may lie outside of the first, small polytope.
class ExpandingPolytope {
 public:
  struct Face {
    std::array<int, 3> vertex;
    std::array<int, 3> neighbor;  // across vertex[i] -> vertex[i + 1]
    Vec3 normal;                  // unit, outward
    double distance = 0.0;        // m, normal . w on the face
    bool alive = true;
  };

  // False when the four points span no volume.
  bool start(const std::array<Vec3, 4>& w);
  // The living face of least signed distance.
  int nearest() const;
  const Face& face(int i) const { return faces_[i]; }
  // Adds a point beyond `face`. False when rounding leaves no proper polytope.
  bool expand(int face, const Vec3& w);

 private:
  bool add_face(int a, int b, int c);

  std::vector<Vec3> points_;
  std::vector<Face> faces_;
  std::vector<int> stack_;
  struct HorizonEdge {
    int tail, head, face, slot;
  };
  std::vector<HorizonEdge> horizon_;
};

struct EpaResult {
  Vec3 normal;          // unit, the way A must move to part
  double depth = 0.0;   // m
  double gap = 0.0;     // m, depth is at most this much above the least
  bool capped = false;  // iterations ran out
};

// `inside` is the simplex GJK ended with. The answer is exact to `tolerance` (m) unless capped.
template <class SupportA, class SupportB>
EpaResult epa(const SupportA& support_a, const SupportB& support_b, const Simplex& inside,
              double tolerance) {
  constexpr int max_iterations = 200;  // smooth sets need about forty
  static thread_local ExpandingPolytope polytope;
  // Support of A - B: out of it, against `d`, A has to be pushed.
  const auto difference = [&](const Vec3& d) -> Vec3 {
    return support_a(d).point - support_b(Vec3(-d)).point;
  };
  EpaResult result;
  result.normal = Vec3::UnitZ();
  result.depth = std::numeric_limits<double>::infinity();
  const auto offer = [&](const Vec3& direction, double reach) {
    if (reach < result.depth) {
      result.depth = reach;
      result.normal = -direction;
    }
  };
  // The tetrahedron around the origin that GJK ended with; else four far points: along x, away from
  // it, off the line, off the plane.
  std::array<Vec3, 4> w;
  for (int i = 0; i < inside.size; ++i) w[i] = inside.vertex[i].w;
  if (inside.size < 4 || !polytope.start(w)) {
    w[0] = difference(Vec3::UnitX());
    w[1] = difference(-Vec3::UnitX());
    offer(Vec3::UnitX(), w[0].x());
    offer(-Vec3::UnitX(), -w[1].x());
    const Vec3 along = (w[1] - w[0]).normalized();
    const Vec3 across = along.unitOrthogonal();
    w[2] = difference(across);
    const double off_line_sq = (w[2] - w[0]).cross(along).squaredNorm();
    if (!(off_line_sq > tolerance * tolerance)) w[2] = difference(-across);
    const Vec3 normal = (w[1] - w[0]).cross(w[2] - w[0]).normalized();
    const Vec3 up = difference(normal), down = difference(-normal);
    w[3] = normal.dot(up - w[0]) > -normal.dot(down - w[0]) ? up : down;
    if (!polytope.start(w)) {
      result.capped = true;
      return result;
    }
  }
  for (int i = 0; i < max_iterations; ++i) {
    const int at = polytope.nearest();
    const Vec3 direction = polytope.face(at).normal;
    const double inner = polytope.face(at).distance;
    const Vec3 next = difference(direction);
    const double reach = direction.dot(next);
    offer(direction, reach);
    result.gap = std::max(0.0, result.depth - inner);
    if (reach - inner <= tolerance || result.gap <= tolerance) return result;
    if (!polytope.expand(at, next)) return result;
  }
  result.capped = true;
  return result;
}

}  // namespace rb
