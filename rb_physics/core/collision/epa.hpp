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

  // Where the supports of A and of B that make up a point were found.
  struct Origin {
    int a = 0, b = 0;
  };

  // False when the four points span no volume.
  bool start(const std::array<Vec3, 4>& w, const std::array<Origin, 4>& origins);
  // The living face of least signed distance.
  int nearest() const;
  const Face& face(int i) const { return faces_[i]; }
  // Of a corner of the face.
  const Origin& origin(int face) const { return origins_[faces_[face].vertex[2]]; }
  // Adds a point beyond `face`. False when rounding leaves no proper polytope.
  bool expand(int face, const Vec3& w, const Origin& origin);

 private:
  bool add_face(int a, int b, int c);

  std::vector<Vec3> points_;
  std::vector<Origin> origins_;  // per point
  std::vector<int> after_;       // per point: the latest face that leaves it along a horizon
  std::vector<Face> faces_;
  std::vector<double> distances_;  // m, per face; infinite once it is gone
  std::vector<int> stack_, gone_;
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
  // Support of A - B: out of it, against `d`, A has to be pushed. A search for it starts at
  // `origin` and leaves there where it ended.
  ExpandingPolytope::Origin origin;
  const auto difference = [&](const Vec3& d) -> Vec3 {
    const SupportPoint a = support_from(support_a, d, origin.a);
    const SupportPoint b = support_from(support_b, Vec3(-d), origin.b);
    origin = {a.index, b.index};
    return a.point - b.point;
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
  std::array<ExpandingPolytope::Origin, 4> origins;
  for (int i = 0; i < inside.size; ++i) {
    w[i] = inside.vertex[i].w;
    origins[i] = {inside.vertex[i].index_a, inside.vertex[i].index_b};
  }
  if (inside.size < 4 || !polytope.start(w, origins)) {
    origins = {};
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
    if (!polytope.start(w, origins)) {
      result.capped = true;
      return result;
    }
  }
  for (int i = 0; i < max_iterations; ++i) {
    const int at = polytope.nearest();
    const Vec3 direction = polytope.face(at).normal;
    const double inner = polytope.face(at).distance;
    origin = polytope.origin(at);
    const Vec3 next = difference(direction);
    const double reach = direction.dot(next);
    offer(direction, reach);
    result.gap = std::max(0.0, result.depth - inner);
    if (reach - inner <= tolerance || result.gap <= tolerance) return result;
    if (!polytope.expand(at, next, origin)) return result;
  }
  result.capped = true;
  return result;
}

}  // namespace rb
