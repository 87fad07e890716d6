// A height field: a grid of heights as a static surface over the x-y plane, solid below, as deep as
// its size. Triangles are made as they are asked for.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "math/types.hpp"
#include "shape/shape.hpp"
#include "shape/triangle.hpp"

namespace rb {

// Sample (i, j) lies at x = i spacing_x, y = j spacing_y. Each cell is split along the diagonal
// (i + 1, j) - (i, j + 1); triangles and edges are numbered from the cells.
struct HeightData {
  int rows = 0;                        // samples along x
  int columns = 0;                     // samples along y
  Vec2 spacing = Vec2::Ones();         // m
  std::vector<double> heights;         // m, size rows * columns, row by row
  std::vector<std::int32_t> patches;   // per triangle: the flat patch it belongs to
  double lowest = 0.0, highest = 0.0;  // m
  double size = 0.0;                   // m, half the diagonal of the bounding box

  Vec3 vertex(std::int32_t id) const {
    const int i = id / columns, j = id % columns;
    return {i * spacing.x(), j * spacing.y(), heights[id]};
  }
  std::array<std::int32_t, 3> corners(std::int32_t triangle) const;
  SurfaceTriangle triangle(std::int32_t index) const;
  void find_patches();  // once, when built
  bool vertex_admits(std::int32_t vertex, const Vec3& normal) const;
  Aabb bounds() const;

  template <class Visit>
  void for_each_triangle(const Aabb& box, Visit&& visit) const {
    const auto cell = [](double x, double step, int samples) {
      return std::clamp(std::floor(x / step), -1.0, static_cast<double>(samples));
    };
    const int first_i = std::max(0, static_cast<int>(cell(box.lower.x(), spacing.x(), rows)));
    const int last_i = std::min(rows - 2, static_cast<int>(cell(box.upper.x(), spacing.x(), rows)));
    const int first_j = std::max(0, static_cast<int>(cell(box.lower.y(), spacing.y(), columns)));
    const int last_j =
        std::min(columns - 2, static_cast<int>(cell(box.upper.y(), spacing.y(), columns)));
    for (int i = first_i; i <= last_i; ++i) {
      for (int j = first_j; j <= last_j; ++j) {
        const double* z = heights.data() + static_cast<std::size_t>(i) * columns + j;
        const auto [low, high] = std::minmax({z[0], z[1], z[columns], z[columns + 1]});
        if (low > box.upper.z() || high < box.lower.z()) continue;
        const std::int32_t first = 2 * (i * (columns - 1) + j);
        visit(first);
        visit(first + 1);
      }
    }
  }

 private:
  std::int32_t neighbor(std::int32_t triangle, int edge) const;  // -1 at the border
};

// `heights` row by row. Throws std::invalid_argument for fewer than 2 samples either way, more than
// 2^27 samples, a count that doesn't fit, heights that aren't finite, spacing that isn't positive.
HeightField make_height_field(int rows, int columns, const std::vector<double>& heights,
                              const Vec2& spacing);

}  // namespace rb
