#include "collision/surface_triangle.hpp"

namespace rb {

double outside(const SurfaceTriangle& t, int k, const Vec3& p) {
  const Vec3 e = t.corner[(k + 1) % 3] - t.corner[k];
  return e.cross(t.normal).dot(p - t.corner[k]) / e.norm();
}

NearestOnTriangle nearest_on(const SurfaceTriangle& t, const Vec3& p) {
  const Vec3 &a = t.corner[0], &b = t.corner[1], &c = t.corner[2];
  const Vec3 ab = b - a, ac = c - a, bc = c - b;
  const double a1 = ab.dot(p - a), a2 = ac.dot(p - a);
  if (a1 <= 0.0 && a2 <= 0.0) return {a, {PrismFeature::CORNER, 0}};
  const double b1 = ab.dot(p - b), b2 = ac.dot(p - b);
  if (b1 >= 0.0 && b2 <= b1) return {b, {PrismFeature::CORNER, 1}};
  const double c1 = ab.dot(p - c), c2 = ac.dot(p - c);
  if (c2 >= 0.0 && c1 <= c2) return {c, {PrismFeature::CORNER, 2}};
  const double vc = a1 * b2 - b1 * a2;
  if (vc <= 0.0 && a1 >= 0.0 && b1 <= 0.0) {
    return {a + (a1 / (a1 - b1)) * ab, {PrismFeature::EDGE, 0}};
  }
  const double vb = c1 * a2 - a1 * c2;
  if (vb <= 0.0 && a2 >= 0.0 && c2 <= 0.0) {
    return {a + (a2 / (a2 - c2)) * ac, {PrismFeature::EDGE, 2}};
  }
  const double va = b1 * c2 - c1 * b2;
  if (va <= 0.0 && b2 - b1 >= 0.0 && c1 - c2 >= 0.0) {
    return {b + ((b2 - b1) / ((b2 - b1) + (c1 - c2))) * bc, {PrismFeature::EDGE, 1}};
  }
  return {p - t.normal.dot(p - a) * t.normal, {PrismFeature::FACE, 0}};
}

bool projects_into(const SurfaceTriangle& t, const Vec3& p, double tolerance) {
  for (int k = 0; k < 3; ++k) {
    if (outside(t, k, p) <= tolerance) continue;
    if (t.edge[k] != EdgeType::CONCAVE) return false;
    const double above = t.neighbor_normal[k].dot(p - t.corner[k]);
    if (above >= 0.0 || outside(t, k, p - above * t.neighbor_normal[k]) > tolerance) return false;
  }
  return true;
}

}  // namespace rb
