#include "collision/reduce.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "math/tolerances.hpp"

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
  static thread_local std::vector<Vec3> gone;
  gone.clear();
  while (points.size() > Manifold::capacity) {
    const std::size_t n = points.size();
    const std::size_t deepest = deepest_of(points);
    // Of points that lie equally deep none is kept for its depth: rounding would choose it.
    const double level =
        tolerance::axis_preference * (points[0].point_b - points[n / 2].point_b).norm();
    const auto deep = [&](const ManifoldPoint& p) {
      return p.separation <= points[deepest].separation + level;
    };
    const bool keep_deepest = std::count_if(points.begin(), points.end(), deep) == 1;
    double least_area = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < n; ++i) {
      if (!(keep_deepest && i == deepest)) {
        least_area = std::min(least_area, ear_area(points, i, normal));
      }
    }
    // Of equal ones the farthest from those gone before, so that a regular outline stays symmetric.
    std::size_t chosen = n;
    double farthest = -1.0;
    for (std::size_t i = 0; i < n; ++i) {
      if (keep_deepest && i == deepest) continue;
      if (ear_area(points, i, normal) > least_area * (1.0 + tolerance::coincident)) continue;
      double nearest = std::numeric_limits<double>::infinity();
      for (const Vec3& p : gone) nearest = std::min(nearest, (points[i].point_b - p).norm());
      if (chosen != n && !(nearest > farthest * (1.0 + tolerance::coincident))) continue;
      chosen = i;
      farthest = nearest;
    }
    gone.push_back(points[chosen].point_b);
    points.erase(points.begin() + static_cast<std::ptrdiff_t>(chosen));
  }
  for (const ManifoldPoint& point : points) out.add(point);
}

// Andrew's monotone chain in the plane across `normal`.
void reduce_cloud(std::vector<ManifoldPoint>& points, const Vec3& normal, Manifold& out) {
  if (points.size() > Manifold::capacity) {
    const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
    const auto x = [&](const ManifoldPoint& p) { return u.dot(p.point_b); };
    const auto y = [&](const ManifoldPoint& p) { return v.dot(p.point_b); };
    std::stable_sort(points.begin(), points.end(), [&](const auto& p, const auto& q) {
      return x(p) != x(q) ? x(p) < x(q) : y(p) < y(q);
    });
    const ManifoldPoint deepest = points[deepest_of(points)];
    std::vector<ManifoldPoint> chain;
    const auto turn = [&](const ManifoldPoint& a, const ManifoldPoint& b, const ManifoldPoint& c) {
      return (x(b) - x(a)) * (y(c) - y(a)) - (y(b) - y(a)) * (x(c) - x(a));
    };
    const auto extend = [&](const ManifoldPoint& p, std::size_t floor) {
      while (chain.size() >= floor + 2 && turn(chain[chain.size() - 2], chain.back(), p) <= 0.0) {
        chain.pop_back();
      }
      chain.push_back(p);
    };
    for (const ManifoldPoint& p : points) extend(p, 0);
    const std::size_t floor = chain.size() - 1;
    for (std::size_t i = points.size() - 1; i-- > 0;) extend(points[i], floor);
    chain.pop_back();
    points = chain;
    const auto same = [&](const ManifoldPoint& p) {
      return p.feature_a == deepest.feature_a && p.feature_b == deepest.feature_b;
    };
    if (std::none_of(points.begin(), points.end(), same)) points.push_back(deepest);
  }
  reduce(points, normal, out);
}

void reduce_by_normal(const std::vector<ManifoldPoint>& points, double angle,
                      std::vector<Manifold>& out) {
  std::vector<bool> taken(points.size(), false);
  std::vector<ManifoldPoint> members;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (taken[i]) continue;
    members.clear();
    for (std::size_t j = i; j < points.size(); ++j) {
      if (taken[j] || (points[j].normal - points[i].normal).squaredNorm() > angle * angle) {
        continue;
      }
      taken[j] = true;
      members.push_back(points[j]);
    }
    out.emplace_back();
    if (members.size() <= static_cast<std::size_t>(Manifold::capacity)) {
      for (const ManifoldPoint& p : members) out.back().add(p);
    } else {
      reduce_cloud(members, points[i].normal, out.back());
    }
  }
}

}  // namespace rb
