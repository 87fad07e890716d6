#include "shape/hull.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "shape/hull_topology.hpp"
#include "shape/polyhedron_mass.hpp"

namespace rb {

namespace {

constexpr int none = -1;
constexpr double coplanar = 1e-10;  // of the extent: triangles this close to a plane are one face
// Of the extent: corners this close are one, the first given. An edge between them would have no
// direction to speak of, and with it no axis to separate shapes along.
constexpr double one_corner = 1e-8;
constexpr std::size_t max_vertices =
    32768;  // what a feature id has room for (collision/feature.hpp)

Vec3 area_normal(const std::vector<Vec3>& points, const HullTriangle& t) {
  const Vec3& a = points[t.vertex[0]];
  return (points[t.vertex[1]] - a).cross(points[t.vertex[2]] - a);
}

double extent(const std::vector<Vec3>& points) {
  Vec3 lower = points[0], upper = points[0];
  for (const Vec3& p : points) {
    lower = lower.cwiseMin(p);
    upper = upper.cwiseMax(p);
  }
  return (upper - lower).maxCoeff();
}

// The points in their order, without those that lie on an earlier one.
std::vector<Vec3> distinct(const std::vector<Vec3>& points) {
  if (points.empty() ||
      !std::all_of(points.begin(), points.end(), [](const Vec3& p) { return p.allFinite(); })) {
    return points;
  }
  const double near = one_corner * extent(points);
  if (points.size() >= 4 && !(near > 0.0)) {
    throw std::invalid_argument("all points of the hull coincide");
  }
  const Vec3 oblique(1.0, 0.618, 0.414);  // grids of points have few equal places along it
  std::vector<double> place(points.size());
  std::vector<int> order(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    place[i] = oblique.dot(points[i]);
    order[i] = static_cast<int>(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return place[i] < place[j]; });
  std::vector<std::size_t> rank(points.size());
  for (std::size_t k = 0; k < order.size(); ++k) rank[order[k]] = k;
  std::vector<char> kept(points.size(), 0);
  std::vector<Vec3> out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto taken = [&](std::size_t k) {
      return kept[order[k]] && (points[order[k]] - points[i]).squaredNorm() <= near * near;
    };
    const auto in_reach = [&](std::size_t k) {
      return std::abs(place[order[k]] - place[i]) <= 2.0 * near;
    };
    bool there = false;
    for (std::size_t k = rank[i]; !there && k-- > 0 && in_reach(k);) there = taken(k);
    for (std::size_t k = rank[i] + 1; !there && k < order.size() && in_reach(k); ++k) {
      there = taken(k);
    }
    if (there) continue;
    kept[i] = 1;
    out.push_back(points[i]);
  }
  return out;
}

// Numbers the triangles by the flat face they belong to, largest triangles first.
std::vector<int> flat_faces(const std::vector<Vec3>& points,
                            const std::vector<HullTriangle>& triangles, double tolerance) {
  std::vector<double> area(triangles.size());
  std::vector<int> order(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    area[i] = area_normal(points, triangles[i]).norm();
    order[i] = static_cast<int>(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return area[i] > area[j]; });
  std::vector<int> face(triangles.size(), none);
  int faces = 0;
  std::vector<int> stack;
  for (const int seed : order) {
    if (face[seed] != none) continue;
    if (!(area[seed] > 0.0)) {
      throw std::invalid_argument("points of the hull lie too close together; merge them");
    }
    const Vec3 normal = area_normal(points, triangles[seed]) / area[seed];
    const Vec3& on_plane = points[triangles[seed].vertex[0]];
    const auto lies_flat = [&](int t) {
      for (const int v : triangles[t].vertex) {
        if (std::abs(normal.dot(points[v] - on_plane)) > tolerance) return false;
      }
      return true;
    };
    face[seed] = faces;
    stack.assign(1, seed);
    while (!stack.empty()) {
      const int t = stack.back();
      stack.pop_back();
      for (const int next : triangles[t].neighbor) {
        if (face[next] != none || !lies_flat(next)) continue;
        face[next] = faces;
        stack.push_back(next);
      }
    }
    ++faces;
  }
  return face;
}

// The rim of every flat face as a loop of point indices, without points in the middle of an edge;
// nothing where the faces are no polygons.
std::optional<std::vector<std::vector<int>>> face_loops(const std::vector<HullTriangle>& triangles,
                                                        const std::vector<int>& face,
                                                        std::size_t points) {
  const int faces = 1 + *std::max_element(face.begin(), face.end());
  std::vector<std::vector<int>> touching(points);  // faces at a point
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const int v : triangles[t].vertex) {
      auto& list = touching[v];
      if (std::find(list.begin(), list.end(), face[t]) == list.end()) list.push_back(face[t]);
    }
  }
  std::vector<std::vector<std::pair<int, int>>> rim(faces);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int e = 0; e < 3; ++e) {
      if (face[triangles[t].neighbor[e]] == face[t]) continue;
      rim[face[t]].emplace_back(triangles[t].vertex[e], triangles[t].vertex[(e + 1) % 3]);
    }
  }
  std::vector<std::vector<int>> loops(faces);
  for (int f = 0; f < faces; ++f) {
    std::sort(rim[f].begin(), rim[f].end());
    const int start = rim[f].front().first;
    int at = start;
    std::size_t walked = 0;
    do {
      if (touching[at].size() >= 3) loops[f].push_back(at);
      const auto edge = std::lower_bound(rim[f].begin(), rim[f].end(), std::make_pair(at, none));
      if (edge == rim[f].end() || edge->first != at || ++walked > rim[f].size()) break;
      at = edge->second;
    } while (at != start);
    if (walked != rim[f].size() || loops[f].size() < 3) return std::nullopt;
  }
  return loops;
}

// Unit normal of a closed polygon (Newell), insensitive to short edges.
Vec3 polygon_normal(const std::vector<Vec3>& points, const std::vector<int>& corners) {
  Vec3 sum = Vec3::Zero();
  const Vec3& origin = points[corners[0]];
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    sum += (points[corners[i]] - origin).cross(points[corners[i + 1]] - origin);
  }
  return sum.normalized();
}

// No corner turns in: else a search from corner to corner could end beside the farthest one.
bool is_convex(const std::vector<Vec3>& points, const std::vector<int>& loop) {
  constexpr double straight = 1e-9;  // sine of the angle
  const Vec3 normal = polygon_normal(points, loop);
  const std::size_t n = loop.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 in = points[loop[(i + 1) % n]] - points[loop[i]];
    const Vec3 out = points[loop[(i + 2) % n]] - points[loop[(i + 1) % n]];
    if (normal.dot(in.cross(out)) < -straight * in.norm() * out.norm()) return false;
  }
  return true;
}

void add_faces(const std::vector<std::vector<int>>& loops, HullData& hull) {
  for (const auto& loop : loops) {
    HullFace face;
    face.normal = polygon_normal(hull.vertices, loop);
    face.first = static_cast<int>(hull.face_vertices.size());
    face.count = static_cast<int>(loop.size());
    for (const int v : loop) hull.face_vertices.push_back(v);
    hull.faces.push_back(face);
  }
}

void add_edges(HullData& hull) {
  struct Side {
    int tail, head, face, corner;
    bool forward;
  };
  std::vector<Side> sides;
  for (int f = 0; f < static_cast<int>(hull.faces.size()); ++f) {
    const HullFace& face = hull.faces[f];
    for (int i = 0; i < face.count; ++i) {
      const int v = hull.face_vertices[face.first + i];
      const int w = hull.face_vertices[face.first + (i + 1) % face.count];
      sides.push_back({std::min(v, w), std::max(v, w), f, face.first + i, v < w});
    }
  }
  std::stable_sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::make_pair(a.tail, a.head) < std::make_pair(b.tail, b.head);
  });
  hull.face_edges.assign(hull.face_vertices.size(), none);
  for (std::size_t i = 0; i + 1 < sides.size(); i += 2) {
    const Side &a = sides[i], &b = sides[i + 1];
    if (a.tail != b.tail || a.head != b.head || a.forward == b.forward) {
      throw std::invalid_argument(
          "nearly coplanar points of the hull can't be sorted into faces; round the points to 1e-9 "
          "of their extent or remove some");
    }
    hull.face_edges[a.corner] = hull.face_edges[b.corner] = static_cast<int>(hull.edges.size());
    hull.edges.push_back(
        {a.tail, a.head, a.forward ? a.face : b.face, a.forward ? b.face : a.face});
  }
  std::vector<std::vector<std::pair<int, int>>> joined(hull.vertices.size());
  for (int e = 0; e < static_cast<int>(hull.edges.size()); ++e) {
    const HullEdge& edge = hull.edges[e];
    joined[edge.tail].emplace_back(edge.head, e);
    joined[edge.head].emplace_back(edge.tail, e);
  }
  hull.neighbor_first.push_back(0);
  for (auto& list : joined) {
    std::sort(list.begin(), list.end());
    for (const auto& [neighbor, edge] : list) {
      hull.neighbors.push_back(neighbor);
      hull.edges_at.push_back(edge);
    }
    hull.neighbor_first.push_back(static_cast<int>(hull.neighbors.size()));
  }
  std::vector<std::vector<int>> around(hull.vertices.size());
  for (int f = 0; f < static_cast<int>(hull.faces.size()); ++f) {
    for (int i = 0; i < hull.faces[f].count; ++i) {
      around[hull.face_vertices[hull.faces[f].first + i]].push_back(f);
    }
  }
  hull.face_first.push_back(0);
  for (const auto& list : around) {
    hull.faces_at.insert(hull.faces_at.end(), list.begin(), list.end());
    hull.face_first.push_back(static_cast<int>(hull.faces_at.size()));
  }
}

// Every face plane supports the hull: no vertex is above it, however badly the normal of a sliver
// is known.
void set_offsets(HullData& hull) {
  constexpr std::size_t few = 1000;  // vertices: all are tried; of more those uphill
  const bool all = hull.vertices.size() <= few;
  for (HullFace& face : hull.faces) {
    int best = hull.face_vertices[face.first];
    face.offset = face.normal.dot(hull.vertices[best]);
    const auto offer = [&](int v) {
      const double reach = face.normal.dot(hull.vertices[v]);
      if (!(reach > face.offset)) return;
      face.offset = reach;
      best = v;
    };
    if (all) {
      for (int v = 0; v < static_cast<int>(hull.vertices.size()); ++v) offer(v);
      continue;
    }
    for (int from = none; from != best;) {
      from = best;
      for (int i = hull.neighbor_first[from]; i < hull.neighbor_first[from + 1]; ++i) {
        offer(hull.neighbors[i]);
      }
    }
  }
}

}  // namespace

void finish_hull(const std::vector<std::vector<int>>& loops, HullData& hull) {
  add_faces(loops, hull);
  add_edges(hull);
  set_offsets(hull);
  hull.size = 0.5 * extent(hull.vertices);
  std::vector<std::array<int, 3>> triangles;
  for (const auto& loop : loops) {
    for (std::size_t i = 1; i + 1 < loop.size(); ++i)
      triangles.push_back({loop[0], loop[i], loop[i + 1]});
  }
  hull.mass = polyhedron_mass(hull.vertices, triangles);
  hull.center = hull.mass.center_of_mass;
  for (const Vec3& v : hull.vertices) hull.radius = std::max(hull.radius, v.norm());
}

ConvexHull make_hull(const std::vector<Vec3>& given) {
  const std::vector<Vec3> points = distinct(given);
  const std::vector<HullTriangle> triangles = hull_triangles(points);
  std::vector<int> face = flat_faces(points, triangles, coplanar * extent(points));
  auto sorted = face_loops(triangles, face, points.size());
  if (!sorted || !std::all_of(sorted->begin(), sorted->end(),
                              [&](const auto& loop) { return is_convex(points, loop); })) {
    // Points about as far from a plane as counts for flat: every triangle is a face of its own.
    std::iota(face.begin(), face.end(), 0);
    sorted = face_loops(triangles, face, points.size());
  }
  if (!sorted) {
    throw std::invalid_argument(
        "nearly coplanar points of the hull can't be sorted into faces; round the points to 1e-9 "
        "of their extent or remove some");
  }
  std::vector<std::vector<int>>& loops = *sorted;

  // Vertices in the order of the input; faces by their smallest vertices.
  std::vector<int> number(points.size(), none);
  for (const auto& loop : loops) {
    for (const int v : loop) number[v] = 0;
  }
  auto hull = std::make_shared<HullData>();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (number[i] == none) continue;
    number[i] = static_cast<int>(hull->vertices.size());
    hull->vertices.push_back(points[i]);
  }
  if (hull->vertices.size() > max_vertices) {
    throw std::invalid_argument("the hull has " + std::to_string(hull->vertices.size()) +
                                " corners; at most 32768 are allowed: simplify the shape");
  }
  for (auto& loop : loops) {
    for (int& v : loop) v = number[v];
    std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
  }
  std::sort(loops.begin(), loops.end());
  finish_hull(loops, *hull);
  const auto v = hull->vertices.size(), e = hull->edges.size(), f = hull->faces.size();
  if (v + f != e + 2) {
    throw std::invalid_argument(
        "nearly coplanar points of the hull can't be sorted into faces; round the points to 1e-9 "
        "of "
        "their extent or remove some");
  }
  return ConvexHull{std::move(hull)};
}

}  // namespace rb
