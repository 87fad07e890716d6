#include "shape/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "shape/polyhedron_mass.hpp"

namespace rb {
namespace {

using Triangle = std::array<std::int32_t, 3>;

[[noreturn]] void refuse(const std::string& what) {
  throw std::invalid_argument("triangle mesh: " + what);
}

std::string name(std::size_t triangle) { return "triangles[" + std::to_string(triangle) + "]"; }

void check(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles) {
  if (triangles.empty()) refuse("it has no triangles; at least one is needed");
  if (triangles.size() > (std::size_t{1} << 27)) refuse("more than 2^27 triangles");
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (!vertices[i].allFinite() || vertices[i].cwiseAbs().maxCoeff() > 1e9) {
      refuse("vertices[" + std::to_string(i) + "] is not three finite numbers of at most 1e9 m");
    }
  }
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (const std::int32_t v : triangles[i]) {
      if (v < 0 || v >= static_cast<std::int64_t>(vertices.size())) {
        refuse(name(i) + " uses vertex " + std::to_string(v) + ", but there are " +
               std::to_string(vertices.size()) + " vertices");
      }
    }
  }
}

// Merges vertices at the same place (files often repeat them per triangle); the first one stays.
void merge_vertices(MeshData& mesh) {
  const double tolerance = 1e-12 * mesh.size;
  const auto& v = mesh.vertices;
  std::vector<std::int32_t> order(v.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::int32_t>(i);
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return std::pair(v[a].x(), a) < std::pair(v[b].x(), b);
  });
  std::vector<std::int32_t> same(v.size());
  for (std::size_t i = 0; i < v.size(); ++i) same[i] = static_cast<std::int32_t>(i);
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (std::size_t j = i; j-- > 0 && v[order[i]].x() - v[order[j]].x() <= tolerance;) {
      const std::int32_t a = std::min(order[i], order[j]), b = std::max(order[i], order[j]);
      if ((v[a] - v[b]).cwiseAbs().maxCoeff() <= tolerance) same[b] = std::min(same[b], same[a]);
    }
  }
  std::vector<std::int32_t> renamed(v.size(), -1);
  std::vector<Vec3> kept;
  for (Triangle& t : mesh.triangles) {
    for (std::int32_t& corner : t) {
      std::int32_t& to = renamed[same[corner]];
      if (to < 0) {
        to = static_cast<std::int32_t>(kept.size());
        kept.push_back(v[same[corner]]);
      }
      corner = to;
    }
  }
  mesh.vertices = std::move(kept);
}

void find_normals(MeshData& mesh) {
  mesh.normals.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.triangles[i];
    const Vec3 u = mesh.vertices[b] - mesh.vertices[a], w = mesh.vertices[c] - mesh.vertices[a];
    const Vec3 n = u.cross(w);
    const double longest_sq = std::max({u.squaredNorm(), w.squaredNorm(), (u - w).squaredNorm()});
    // Height over the longest edge below 1e-10 of it: no normal can be told.
    if (!(n.norm() > 1e-10 * longest_sq)) {
      refuse(name(i) + " has no area (its corners coincide or lie on a line); remove it");
    }
    mesh.normals.push_back(n.normalized());
  }
}

struct HalfEdge {
  std::int32_t low, high;  // vertices
  std::int32_t triangle, edge;
  bool forward;  // runs from low to high
};

void join_edges(MeshData& mesh) {
  std::vector<HalfEdge> half_edges;
  half_edges.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t from = mesh.triangles[t][k], to = mesh.triangles[t][(k + 1) % 3];
      half_edges.push_back(
          {std::min(from, to), std::max(from, to), static_cast<std::int32_t>(t), k, from < to});
    }
  }
  std::sort(half_edges.begin(), half_edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  mesh.neighbors.assign(mesh.triangles.size(), {-1, -1, -1});
  mesh.edges.assign(mesh.triangles.size(),
                    {EdgeType::BOUNDARY, EdgeType::BOUNDARY, EdgeType::BOUNDARY});
  mesh.closed = true;
  mesh.at_boundary.assign(mesh.vertices.size(), false);
  std::vector<std::pair<std::int32_t, std::int32_t>> links;
  for (std::size_t i = 0, end; i < half_edges.size(); i = end) {
    const HalfEdge& a = half_edges[i];
    end = i + 1;
    while (end < half_edges.size() && half_edges[end].low == a.low &&
           half_edges[end].high == a.high) {
      ++end;
    }
    links.emplace_back(a.low, a.high);
    links.emplace_back(a.high, a.low);
    EdgeType type = EdgeType::BOUNDARY;
    if (end - i > 2) {
      refuse("the edge between " + name(a.triangle) + " and " + name(half_edges[i + 1].triangle) +
             " is shared by more than two triangles");
    }
    if (end - i == 2) {
      const HalfEdge& b = half_edges[i + 1];
      if (a.forward == b.forward) {
        refuse(name(a.triangle) + " and " + name(b.triangle) +
               " run their common edge the same way; all triangles must be counterclockwise seen "
               "from outside");
      }
      const Vec3& beyond = mesh.vertices[mesh.triangles[b.triangle][(b.edge + 2) % 3]];
      type = edge_type(mesh.normals[a.triangle], mesh.normals[b.triangle], mesh.vertices[a.low],
                       beyond);
      mesh.neighbors[a.triangle][a.edge] = b.triangle;
      mesh.neighbors[b.triangle][b.edge] = a.triangle;
      mesh.edges[a.triangle][a.edge] = mesh.edges[b.triangle][b.edge] = type;
    } else {
      mesh.closed = false;
      mesh.at_boundary[a.low] = mesh.at_boundary[a.high] = true;
    }
  }
  std::sort(links.begin(), links.end());
  mesh.ring_first.assign(mesh.vertices.size() + 1, 0);
  for (const auto& [from, to] : links) {
    ++mesh.ring_first[from + 1];
    mesh.ring.push_back(to);
  }
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    mesh.ring_first[v + 1] += mesh.ring_first[v];
}

}  // namespace

TriangleMesh make_triangle_mesh(const std::vector<Vec3>& vertices,
                                const std::vector<Triangle>& triangles) {
  check(vertices, triangles);
  auto mesh = std::make_shared<MeshData>();
  mesh->vertices = vertices;
  mesh->triangles = triangles;
  Aabb all{vertices[triangles[0][0]], vertices[triangles[0][0]]};
  for (const Triangle& t : triangles) {
    for (const std::int32_t v : t) {
      all.lower = all.lower.cwiseMin(vertices[v]);
      all.upper = all.upper.cwiseMax(vertices[v]);
    }
  }
  mesh->size = 0.5 * (all.upper - all.lower).norm();
  merge_vertices(*mesh);
  find_normals(*mesh);
  join_edges(*mesh);
  mesh->patches = flat_patches(
      static_cast<std::int32_t>(mesh->triangles.size()),
      [&](std::int32_t t, int k) { return mesh->neighbors[t][k]; },
      [&](std::int32_t t, int k) { return mesh->edges[t][k] == EdgeType::FLAT; });
  std::vector<Aabb> boxes;
  for (const Triangle& t : mesh->triangles) {
    const Vec3 &a = mesh->vertices[t[0]], &b = mesh->vertices[t[1]], &c = mesh->vertices[t[2]];
    boxes.push_back({a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)});
  }
  mesh->bvh = Bvh(boxes);
  if (mesh->closed) {
    mesh->mass = polyhedron_mass(mesh->vertices, mesh->triangles);
    mesh->volume = mesh->mass.mass;
    if (mesh->volume < 0.0) {
      refuse("it is inside out (volume " + std::to_string(mesh->volume) +
             " m^3): swap two corners of every triangle");
    }
  }
  return {mesh};
}

SurfaceTriangle MeshData::triangle(std::int32_t index) const {
  SurfaceTriangle t;
  const auto& corners = triangles[index];
  t.normal = normals[index];
  t.face_id = index;
  t.patch_id = patches[index];
  for (int k = 0; k < 3; ++k) {
    const std::int32_t neighbor = neighbors[index][k];
    t.corner[k] = vertices[corners[k]];
    t.edge[k] = edges[index][k];
    t.neighbor_normal[k] = neighbor >= 0 ? normals[neighbor] : normals[index];
    t.corner_id[k] = corners[k];
    // Named after the triangle that owns it.
    std::int32_t owner = index, slot = k;
    if (neighbor >= 0 && neighbor < index) {
      owner = neighbor;
      for (slot = 0; neighbors[neighbor][slot] != index; ++slot) {
      }
    }
    t.edge_id[k] = 3 * owner + slot;
  }
  return t;
}

bool MeshData::vertex_admits(std::int32_t vertex, const Vec3& normal) const {
  bool sharp = at_boundary[vertex];
  for (std::int32_t i = ring_first[vertex]; i < ring_first[vertex + 1]; ++i) {
    const Vec3 along = vertices[ring[i]] - vertices[vertex];
    const double rise = normal.dot(along), flat = flat_angle * along.norm();
    if (rise > flat) return false;
    sharp = sharp || rise < -flat;
  }
  return sharp;
}

}  // namespace rb
