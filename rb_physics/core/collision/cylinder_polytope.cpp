// Cylinder against box or hull.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "collision/cylinder_axis.hpp"
#include "collision/cylinder_contacts.hpp"
#include "collision/pairs.hpp"
#include "collision/polytope.hpp"
#include "collision/reduce.hpp"

namespace rb {

namespace {

AxisEdge axis_edge(const Polytope& b, int e) {
  const HullEdge& edge = b.topology().edges[e];
  const Vec3 tail = b.vertex(edge.tail), along = b.vertex(edge.head) - tail;
  const double length = along.norm();
  return {tail, along / length, length, 0.0, e};
}

// The features of B, all or those around the vertices where the two are nearest.
class FeatureSearch {
 public:
  FeatureSearch(const PlacedCylinder& a, const Polytope& b, double preference, double tolerance)
      : a_(a), b_(b), search_(a, preference, tolerance) {}

  CylinderAxisSearch& around(const Simplex& nearest) {
    const auto each = [&](const auto& visit) {
      for (int i = 0; i < nearest.size; ++i) visit(nearest.vertex[i].index_b);
    };
    each([&](int v) { b_.for_each_face_at(v, [&](int f) { face(f); }); });
    caps(nearest.vertex[0].index_b);
    each([&](int v) { corner(v); });
    each([&](int v) { b_.for_each_edge_at(v, [&](int e) { edge(e); }); });
    return search_;
  }

  CylinderAxisSearch& everywhere() {
    static thread_local std::vector<FaceSample> faces;
    faces.clear();
    for (int f = 0; f < b_.face_count(); ++f) faces.push_back(face(f));
    caps(0);
    for (int v = 0; v < b_.vertex_count(); ++v) corner(v);
    const auto& edges = b_.topology().edges;
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const FaceSample &left = faces[edges[e].left], &right = faces[edges[e].right];
      if (!may_matter(left, right, b_.vertex(edges[e].tail))) continue;
      edge(static_cast<int>(e));
    }
    return search_;
  }

 private:
  struct FaceSample {
    Vec3 normal, lowest;  // lowest: the cylinder's point farthest against the normal, m
    double separation;    // m
  };

  // Between the normals of an edge's faces the separation lies under the tangent planes of both.
  bool may_matter(const FaceSample& left, const FaceSample& right, const Vec3& tail) const {
    if (left.separation >= 0.0 || right.separation >= 0.0) return true;
    if (left.normal.dot(right.normal) < 0.0) return true;
    const double bound = std::min(std::max(left.separation, right.normal.dot(left.lowest - tail)),
                                  std::max(right.separation, left.normal.dot(right.lowest - tail)));
    return !search_.useless(bound);
  }

  FaceSample face(int f) {
    const Vec3 n = b_.normal(f), lowest = a_(Vec3(-n)).point;
    const double separation = b_.height(f, lowest);
    search_.offer_flat(CylinderAxis::FACE, n, separation, f);
    return {n, lowest, separation};
  }
  void caps(int start) {
    for (const bool upper : {true, false}) {
      const Vec3 n = -a_.cap_normal(upper);
      const double separation = n.dot(a_.cap_center(upper) - b_.vertex(b_.farthest(n, start)));
      search_.offer_flat(CylinderAxis::CAP, n, separation, upper ? 0 : 1);
    }
  }
  void corner(int v) {
    // No vertex reaches farther than one whose neighbors don't.
    search_.offer_corner(b_.vertex(v), v, [&](const Vec3& n) {
      double reach = n.dot(b_.vertex(v));
      const HullData& hull = b_.topology();
      for (int i = hull.neighbor_first[v]; i < hull.neighbor_first[v + 1]; ++i) {
        const double other = n.dot(b_.vertex(hull.neighbors[i]));
        if (other > reach + 1e-9 * b_.size()) return other;
        reach = std::max(reach, other);
      }
      return reach;
    });
  }
  void edge(int e) {
    const HullEdge& edge = b_.topology().edges[e];
    const Vec3 left = b_.normal(edge.left), right = b_.normal(edge.right);
    const AxisEdge placed = axis_edge(b_, e);
    search_.offer_crossing(placed, left, right);
    search_.offer_rim(placed, left, right);
  }

  const PlacedCylinder& a_;
  const Polytope& b_;
  CylinderAxisSearch search_;
};

// The vertex or edge of B that looks along the normal.
std::uint32_t facing_feature(const Polytope& b, const Vec3& normal, int vertex, Vec3& along) {
  std::uint32_t feature = make_feature(FeatureType::VERTEX, vertex);
  along = Vec3::Zero();
  double least_slope = tolerance::parallel;
  b.for_each_edge_at(vertex, [&](int e) {
    const HullEdge& edge = b.topology().edges[e];
    const Vec3 out = b.vertex(edge.tail == vertex ? edge.head : edge.tail) - b.vertex(vertex);
    const double slope = std::abs(normal.dot(out)) / out.norm();
    if (!(slope <= least_slope)) return;
    least_slope = slope;
    feature = b.edge_feature(e);
    along = out;
  });
  return feature;
}

// The side along a parallel edge: both ends of the common part. False: there is none, or it is not
// where the two are nearest.
bool side_by_side(const PlacedCylinder& a, const Polytope& b, const CylinderAxis& axis,
                  double tolerance, std::vector<ManifoldPoint>& points) {
  const int vertex = b.farthest(axis.normal);
  Vec3 edge;
  ManifoldPoint p;
  p.feature_b = facing_feature(b, axis.normal, vertex, edge);
  const double length = edge.norm();
  if (!(length > 0.0)) return false;
  const Vec3 middle = b.vertex(vertex) + 0.5 * edge, along = edge / length;
  SideOverlap side;
  if (!side_overlap(a, -axis.normal, middle, along, 0.5 * length, tolerance, side)) return false;
  p.normal = -side.normal;
  const double proven = p.normal.dot(a(side.normal).point - b.vertex(b.farthest(p.normal, vertex)));
  if (!carries(side, proven, axis.separation, tolerance)) return false;
  const bool same_way = a.axis.dot(along) > 0.0;
  for (const int i : same_way ? std::array{0, 1} : std::array{1, 0}) {
    p.separation = side.separation[i];
    p.point_b = middle + side.t[i] * along;
    p.point_a = p.point_b + p.separation * p.normal;
    const bool upper = (i == 0) == same_way;
    p.feature_a = side.of_cylinder[i] ? PlacedCylinder::rim_feature(upper)
                                      : make_feature(FeatureType::SMOOTH, upper ? 2 : 3);
    points.push_back(p);
  }
  return true;
}

// The one point of an axis that belongs to neither a cap nor a face.
ManifoldPoint single_contact(const PlacedCylinder& a, const Polytope& b, const CylinderAxis& axis) {
  ManifoldPoint p;
  p.normal = axis.normal;
  p.separation = axis.separation;
  p.point_a = axis.on_cylinder;
  p.point_b = axis.on_other;
  p.feature_a = a.part_facing(-axis.normal) == PlacedCylinder::Part::SIDE
                    ? PlacedCylinder::side_feature()
                    : PlacedCylinder::rim_feature(a.axis.dot(axis.normal) < 0.0);
  p.feature_b = axis.kind == CylinderAxis::CORNER ? make_feature(FeatureType::VERTEX, axis.feature)
                                                  : b.edge_feature(axis.feature);
  if (axis.kind == CylinderAxis::CROSSING) p.normal_owner = NormalOwner::EDGES;
  return p;
}

// The deepest point alone, should rounding leave nothing over the face or under the cap.
ManifoldPoint deepest_contact(const PlacedCylinder& a, const Polytope& b,
                              const CylinderAxis& axis) {
  ManifoldPoint p;
  p.normal = axis.normal;
  p.separation = axis.separation;
  const bool upper = a.axis.dot(axis.normal) < 0.0;
  if (axis.kind == CylinderAxis::FACE) {
    p.point_a = a(Vec3(-axis.normal)).point;
    p.point_b = p.point_a - axis.separation * axis.normal;
    p.feature_a = PlacedCylinder::rim_feature(upper);
    p.feature_b = make_feature(FeatureType::FACE, axis.feature);
    p.normal_owner = NormalOwner::B;
  } else {
    const int vertex = b.farthest(axis.normal);
    p.point_b = b.vertex(vertex);
    p.point_a = p.point_b + axis.separation * axis.normal;
    p.feature_a = PlacedCylinder::cap_feature(upper);
    p.feature_b = make_feature(FeatureType::VERTEX, vertex);
    p.normal_owner = NormalOwner::A;
  }
  return p;
}

void flat_contacts(const PlacedCylinder& a, const Polytope& b, const CylinderAxis& axis,
                   double margin, double tolerance, std::vector<ManifoldPoint>& points) {
  static thread_local std::vector<PolygonCorner> corners;
  if (axis.kind == CylinderAxis::FACE) {
    const FacePolygon polygon = b.polygon(axis.feature, corners);
    const PlanarRegion region{polygon.normal, corners[0].point, polygon.face, &polygon, 0.0};
    cylinder_on_region(a, region, margin, tolerance, points);
  } else {
    const FacePolygon polygon =
        b.polygon(b.opposing_face(-axis.normal, b.farthest(axis.normal)), corners);
    polygon_on_cap(a, axis.feature == 0, polygon, CapNormal::OF_CAP, margin, tolerance, points);
  }
}

// A cap that leans a little against a face: what else of them is near.
void nearly_flat_contacts(const PlacedCylinder& a, const Polytope& b, const Vec3& normal,
                          double margin, double tolerance, std::vector<ManifoldPoint>& points) {
  static thread_local std::vector<PolygonCorner> corners;
  static thread_local std::vector<ManifoldPoint> more;
  const bool upper = a.axis.dot(normal) < 0.0;
  if (!nearly_flat(a.cap_normal(upper), normal)) return;
  const FacePolygon polygon = b.polygon(b.opposing_face(-normal, b.farthest(normal)), corners);
  if (!nearly_flat(a.cap_normal(upper), polygon.normal)) return;
  const PlanarRegion region{polygon.normal, corners[0].point, polygon.face, &polygon, 0.0};
  more.clear();
  cylinder_on_region(a, region, margin, tolerance, more);
  polygon_on_cap(a, upper, polygon, CapNormal::OF_POLYGON, margin, tolerance, more);
  add_shallower(more, tolerance, points);
}

void contacts(const Cylinder& shape, const Placement& at, const Polytope& b, double margin,
              Manifold& out) {
  static thread_local std::vector<ManifoldPoint> points;
  const PlacedCylinder a(shape, at);
  const double small = std::min(a.size(), b.size()), large = std::max(a.size(), b.size());
  const double tolerance = tolerance::coincident * small + 1e-14 * large;
  const double preference = tolerance::axis_preference * small + 1e-15 * large;
  const GjkResult nearest =
      gjk(a, b, Vec3(a.center - b.center()), margin, 1e-9 * small, 1e-14, 1e-13 * small);
  if (nearest.status == GjkStatus::BEYOND) return;
  const auto find = [&] {
    if (nearest.status == GjkStatus::SEPARATED) {
      FeatureSearch search(a, b, preference, tolerance);
      const CylinderAxisSearch& found = search.around(nearest.simplex);
      // No two points are nearer than an axis proves.
      if (found.best().separation >= nearest.distance - preference) return found;
    }
    FeatureSearch search(a, b, preference, tolerance);
    return search.everywhere();
  };
  const CylinderAxisSearch found = find();
  const CylinderAxis& axis = found.best();
  if (!(axis.separation <= margin)) return;
  points.clear();
  const bool free_known = found.free().kind != CylinderAxis::NONE;
  if (found.prefers_flat()) {
    flat_contacts(a, b, axis, margin, tolerance, points);
    if (least_separation(points) > axis.separation + tolerance) {
      points.clear();
      if (free_known && found.free().separation >= axis.separation - tolerance) {
        points.push_back(single_contact(a, b, found.free()));
      } else {
        points.push_back(deepest_contact(a, b, axis));
      }
    }
  } else if (!side_by_side(a, b, axis, tolerance, points)) {
    points.push_back(single_contact(a, b, axis));
  }
  nearly_flat_contacts(a, b, axis.normal, margin, tolerance, points);
  reduce_cloud(points, axis.normal, out);
}

}  // namespace

void contacts_cylinder_box(const Cylinder& a, const Placement& at_a, const Box& b,
                           const Placement& at_b, double margin, Manifold& out) {
  contacts(a, at_a, placed_polytope(b, at_b), margin, out);
}

void contacts_cylinder_hull(const Cylinder& a, const Placement& at_a, const ConvexHull& b,
                            const Placement& at_b, double margin, Manifold& out) {
  contacts(a, at_a, placed_polytope(b, at_b), margin, out);
}

}  // namespace rb
