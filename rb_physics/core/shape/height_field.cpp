#include "shape/height_field.hpp"

#include <stdexcept>
#include <string>

namespace rb {

HeightField make_height_field(int rows, int columns, const std::vector<double>& heights,
                              const Vec2& spacing) {
  const auto refuse = [](const std::string& what) {
    throw std::invalid_argument("height field: " + what);
  };
  if (rows < 2 || columns < 2) refuse("it needs at least 2 x 2 heights");
  if (static_cast<std::int64_t>(rows) * columns > (std::int64_t{1} << 27)) {
    refuse("more than 2^27 heights");
  }
  if (heights.size() != static_cast<std::size_t>(rows) * columns) {
    refuse("the number of heights is not rows * columns");
  }
  if (!(spacing.minCoeff() >= 1e-9 && spacing.maxCoeff() <= 1e9)) {
    refuse("spacing must lie between 1e-9 and 1e9 m");
  }
  for (std::size_t i = 0; i < heights.size(); ++i) {
    if (!(std::abs(heights[i]) <= 1e9)) {
      refuse("heights[" + std::to_string(i / columns) + "][" + std::to_string(i % columns) +
             "] is not a finite number of at most 1e9 m");
    }
  }
  auto field = std::make_shared<HeightData>();
  field->rows = rows;
  field->columns = columns;
  field->spacing = spacing;
  field->heights = heights;
  const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
  field->lowest = *low;
  field->highest = *high;
  const Aabb box = field->bounds();
  field->size = 0.5 * (box.upper - box.lower).norm();
  field->find_patches();
  return {field};
}

Aabb HeightData::bounds() const {
  return {Vec3(0.0, 0.0, lowest),
          Vec3((rows - 1) * spacing.x(), (columns - 1) * spacing.y(), highest)};
}

std::array<std::int32_t, 3> HeightData::corners(std::int32_t triangle) const {
  const std::int32_t cell = triangle / 2, i = cell / (columns - 1), j = cell % (columns - 1);
  const std::int32_t at = i * columns + j;
  if (triangle % 2 == 0) return {at, at + columns, at + 1};
  return {at + columns, at + columns + 1, at + 1};
}

std::int32_t HeightData::neighbor(std::int32_t triangle, int edge) const {
  const std::int32_t cell = triangle / 2;
  std::int32_t i = cell / (columns - 1), j = cell % (columns - 1);
  const bool first = triangle % 2 == 0;
  if (edge == (first ? 1 : 2)) return triangle ^ 1;  // the diagonal
  if (first) {
    --(edge == 0 ? j : i);
  } else {
    ++(edge == 0 ? i : j);
  }
  if (i < 0 || j < 0 || i >= rows - 1 || j >= columns - 1) return -1;
  return 2 * (i * (columns - 1) + j) + (first ? 1 : 0);
}

namespace {

Vec3 unit_normal(const HeightData& field, const std::array<std::int32_t, 3>& c) {
  const Vec3 a = field.vertex(c[0]);
  return (field.vertex(c[1]) - a).cross(field.vertex(c[2]) - a).normalized();
}

}  // namespace

SurfaceTriangle HeightData::triangle(std::int32_t index) const {
  SurfaceTriangle t;
  t.face_id = index;
  t.patch_id = patches.empty() ? index : patches[index];
  t.corner_id = corners(index);
  t.normal = unit_normal(*this, t.corner_id);
  for (int k = 0; k < 3; ++k) t.corner[k] = vertex(t.corner_id[k]);
  for (int k = 0; k < 3; ++k) {
    const std::int32_t other = neighbor(index, k);
    t.edge_id[k] = 3 * index + k;
    if (other < 0) {
      t.edge[k] = EdgeType::BOUNDARY;
      t.neighbor_normal[k] = t.normal;
      continue;
    }
    const auto c = corners(other);
    t.neighbor_normal[k] = unit_normal(*this, c);
    for (int slot = 0; slot < 3; ++slot) {
      if (neighbor(other, slot) != index) continue;
      t.edge[k] = edge_type(t.normal, t.neighbor_normal[k], t.corner[k], vertex(c[(slot + 2) % 3]));
      if (other < index) t.edge_id[k] = 3 * other + slot;
    }
  }
  return t;
}

void HeightData::find_patches() {
  patches = flat_patches(
      2 * (rows - 1) * (columns - 1), [this](std::int32_t t, int k) { return neighbor(t, k); },
      [this](std::int32_t t, int k) { return triangle(t).edge[k] == EdgeType::FLAT; });
}

bool HeightData::vertex_admits(std::int32_t id, const Vec3& normal) const {
  const int i = id / columns, j = id % columns;
  const Vec3 at = vertex(id);
  bool sharp = i == 0 || j == 0 || i == rows - 1 || j == columns - 1;
  static constexpr int ring[6][2] = {{1, 0}, {0, 1}, {-1, 1}, {-1, 0}, {0, -1}, {1, -1}};
  for (const auto& [di, dj] : ring) {
    if (i + di < 0 || j + dj < 0 || i + di >= rows || j + dj >= columns) continue;
    const Vec3 along = vertex((i + di) * columns + j + dj) - at;
    const double rise = normal.dot(along), flat = flat_angle * along.norm();
    if (rise > flat) return false;
    sharp = sharp || rise < -flat;
  }
  return sharp;
}

}  // namespace rb
