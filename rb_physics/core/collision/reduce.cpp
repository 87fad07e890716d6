#include "collision/reduce.hpp"

#include <limits>

namespace rb {

namespace {

// Twice the area lost when corner i goes.
double ear_area(const std::vector<ManifoldPoint>& points, std::size_t i, const Vec3& normal) {
  const std::size_t n = points.size();
  const Vec3& before = points[(i + n - 1) % n].point_b;
  const Vec3& after = points[(i + 1) % n].point_b;
  return std::abs(normal.dot((points[i].point_b - before).cross(after - before)));
}

std::size_t deepest_of(const std::vector<ManifoldPoint>& points) {
  std::size_t deepest = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].separation < points[deepest].separation) deepest = i;
  }
  return deepest;
}

}  // namespace

void reduce(std::vector<ManifoldPoint>& points, const Vec3& normal, Manifold& out) {
  while (points.size() > Manifold::capacity) {
    const std::size_t deepest = deepest_of(points);
    std::size_t least = 0;
    double least_area = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (i == deepest) continue;
      const double area = ear_area(points, i, normal);
      if (area < least_area) {
        least_area = area;
        least = i;
      }
    }
    points.erase(points.begin() + static_cast<std::ptrdiff_t>(least));
  }
  for (const ManifoldPoint& point : points) out.add(point);
}

}  // namespace rb
