#include "collision/surface_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "collision/reduce.hpp"
#include "collision/surface_data.hpp"
#include "collision/surface_features.hpp"
#include "collision/surface_triangle.hpp"
#include "collision/triangle_prism.hpp"
#include "math/tolerances.hpp"

namespace rb {
namespace {

// A surface's feature as the 31 bits of half a contact id: type and 29 bits of index.
std::uint32_t surface_feature(FeatureType type, std::int32_t index) {
  const auto i = static_cast<std::uint32_t>(index);
  return with_part(make_feature(type, i & ((1u << feature_index_bits) - 1)),
                   i >> feature_index_bits);
}

// Is the point behind the surface that the triangles are part of? The nearest tells; of several as
// near (over an edge or corner) the one that sees it most steeply.
bool is_behind(const std::vector<SurfaceTriangle>& triangles, const Vec3& point) {
  double nearest_sq = std::numeric_limits<double>::infinity();
  double height = 0.0;
  for (const SurfaceTriangle& t : triangles) {
    const Vec3 gap = point - nearest_on(t, point).point;
    const double sq = gap.squaredNorm(), above = t.normal.dot(gap);
    const double rounding = 1e-9 * nearest_sq;
    if (sq > nearest_sq + rounding) continue;
    if (sq < nearest_sq - rounding || std::abs(above) > std::abs(height)) height = above;
    nearest_sq = std::min(nearest_sq, sq);
  }
  return height < 0.0;
}

template <class Data>
class Finder {
 public:
  Finder(const Data& data, const Shape& surface, const Shape& shape, const Pose& pose,
         double margin)
      : data_(data),
        surface_(surface),
        shape_(shape),
        pose_(pose),
        at_{pose.orientation.toRotationMatrix(), pose.position},
        margin_(margin),
        size_(characteristic_size(shape)) {
    center_ = center_of(shape, pose);
    Aabb box = bounding_box(shape, pose);
    box.lower.array() -= margin;
    box.upper.array() += margin;
    triangles_.clear();
    data.for_each_triangle(box, [&](std::int32_t i) { triangles_.push_back(data.triangle(i)); });
    // The walk's order is the tree's; ids make it that of the mesh.
    std::sort(
        triangles_.begin(), triangles_.end(),
        [](const SurfaceTriangle& a, const SurfaceTriangle& b) { return a.face_id < b.face_id; });
    // A particle on the sheet is on no side of it: it keeps to the front.
    if (is_sheet(data) && !std::holds_alternative<Particle>(shape) &&
        is_behind(triangles_, center_)) {
      for (SurfaceTriangle& t : triangles_) t = turned_over(t);
    }
  }

  // Contacts in the surface's frame.
  const std::vector<ManifoldPoint>& contacts() {
    points_.clear();
    const bool particle = std::holds_alternative<Particle>(shape_);
    const auto* sphere = std::get_if<Sphere>(&shape_);
    for (const SurfaceTriangle& t : triangles_) {
      if (particle || sphere != nullptr) {
        touch_ball(t, sphere != nullptr ? sphere->radius : 0.0, particle);
      } else if (in_front(t)) {
        touch_face(t);
        touch_edges(t);
      }
    }
    if (points_.empty() && !particle && sphere == nullptr) push_out();
    if (points_.empty() && is_inside(surface_, center_)) surface_from_inside();
    return points_;
  }

 private:
  static std::uint32_t name(const SurfaceTriangle& t, const PrismFeature& f) {
    switch (f.kind) {
      case PrismFeature::EDGE:
        return surface_feature(FeatureType::EDGE, t.edge_id[f.index]);
      case PrismFeature::CORNER:
        return surface_feature(FeatureType::VERTEX, t.corner_id[f.index]);
      default:
        return surface_feature(FeatureType::FACE, t.patch_id);
    }
  }

  // Keeps a contact unless a neighbour has already reported the same one.
  void keep(const ManifoldPoint& p) {
    for (const ManifoldPoint& other : points_) {
      if (other.feature_a != p.feature_a) continue;
      const bool same_feature = other.feature_b == p.feature_b;
      const bool same_plane = (other.normal - p.normal).squaredNorm() < flat_angle * flat_angle;
      const bool same_point = (other.point_b - p.point_b).squaredNorm() <
                              tolerance::coincident * tolerance::coincident * size_ * size_;
      if (same_point && (same_feature || same_plane)) return;
    }
    points_.push_back(p);
  }

  void touch_ball(const SurfaceTriangle& t, double radius, bool particle) {
    const double height = t.normal.dot(center_ - t.corner[0]);
    // A centre farther behind than the radius came from the other side of a thin wall.
    if (height - radius > margin_ || height < -std::max(radius, slack(data_))) return;
    const NearestOnTriangle nearest = nearest_on(t, center_);
    ManifoldPoint p;
    p.feature_a = make_feature(particle ? FeatureType::VERTEX : FeatureType::SMOOTH, 0);
    p.kind = ContactKind::SMOOTH;
    // Over a seam the nearest point is on an edge, yet the faces carry.
    const bool in_seam = particle && is_in_seam(t);
    if (in_seam || projects_into(t, center_, 1e-12 * size_)) {
      p.normal = t.normal;
      p.normal_owner = NormalOwner::B;
      p.separation = height - radius;
      p.feature_b = surface_feature(FeatureType::FACE, t.patch_id);
      if (particle) p.kind = ContactKind::VERTEX_FACE;
      p.point_b = center_ - height * t.normal;
      if (height < -1e-12 * size_ && !in_seam && better_exit(t, center_, -height)) return;
    } else {
      const Vec3 gap = center_ - nearest.point;
      const double length = gap.norm();
      if (!(length > 0.0) || length - radius > margin_) return;
      p.normal = gap / length;
      if (!admits(data_, t, nearest.feature, p.normal)) return;
      p.normal_owner = NormalOwner::CENTERS;
      p.separation = length - radius;
      p.feature_b = name(t, nearest.feature);
      p.point_b = nearest.point;
    }
    p.point_a = center_ - radius * p.normal;
    keep(p);
  }

  // Is the particle at the bottom of a valley, over the triangle or hardly beyond its edge there?
  // Both slopes carry, however little it has sunk into one or both.
  bool is_in_seam(const SurfaceTriangle& t) const {
    const double tolerance = 1e-12 * size_;
    bool at_seam = false;
    for (int k = 0; k < 3; ++k) {
      const double beyond = outside(t, k, center_);
      const bool sinks = t.edge[k] == EdgeType::CONCAVE && std::abs(beyond) <= slack(data_) &&
                         t.neighbor_normal[k].dot(center_ - t.corner[k]) <= tolerance;
      if (beyond > tolerance && !sinks) return false;
      at_seam |= sinks;
    }
    return at_seam;
  }

  bool in_front(const SurfaceTriangle& t) const {
    return t.normal.dot(center_ - t.corner[0]) >= 0.0;
  }

  // Points of the shape against the face: the plane's manifold, cut to the triangle.
  void touch_face(const SurfaceTriangle& t) {
    const double offset = t.normal.dot(t.corner[0]);
    if (!plane_ || plane_->normal != t.normal || plane_->offset != offset) {
      plane_ = HalfSpace{t.normal, offset};
      on_plane_.clear();
      leaf_contacts(shape_, at_, Shape(*plane_), Placement{}, margin_, on_plane_);
    }
    const double tolerance = 1e-12 * size_;
    for (int i = 0; i < on_plane_.size(); ++i) {
      ManifoldPoint p = on_plane_[i];
      if (!projects_into(t, p.point_a, tolerance)) continue;
      if (p.separation < -tolerance && better_exit(t, p.point_a, -p.separation)) continue;
      if (p.separation < -deep() && !came_through(p.point_a)) continue;
      p.feature_b = surface_feature(FeatureType::FACE, t.patch_id);
      keep(p);
    }
  }

  // Deep inside, no feature may be left that its neighbours admit: then one point along the face
  // that the shape is least deep behind.
  void push_out() {
    ManifoldPoint least;
    least.separation = -std::numeric_limits<double>::infinity();
    for (const SurfaceTriangle& t : triangles_) {
      if (!in_front(t) || !meets(t)) continue;
      Manifold plane;
      leaf_contacts(shape_, at_, Shape(HalfSpace{t.normal, t.normal.dot(t.corner[0])}), Placement{},
                    0.0, plane);
      int deepest = 0;
      for (int i = 1; i < plane.size(); ++i) {
        if (plane[i].separation < plane[deepest].separation) deepest = i;
      }
      if (plane.size() == 0 || plane[deepest].separation <= least.separation) continue;
      least = plane[deepest];
      least.feature_b = surface_feature(FeatureType::FACE, t.patch_id);
    }
    if (std::isfinite(least.separation)) points_.push_back(least);
  }

  // The centre is inside of the solid: out through the nearest point of the surface, by the plane
  // there.
  void surface_from_inside() {
    const Aabb all = surface_bounds(data_);
    double nearest_sq = std::numeric_limits<double>::infinity();
    std::int32_t through = -1;
    Vec3 exit = Vec3::Zero(), normal = Vec3::UnitZ();
    double reach = size_;
    for (bool complete = false; !complete && nearest_sq > reach * reach; reach *= 8.0) {
      const Aabb near{center_.array() - reach, center_.array() + reach};
      complete = (near.lower.array() <= all.lower.array()).all() &&
                 (near.upper.array() >= all.upper.array()).all();
      data_.for_each_triangle(near, [&](std::int32_t i) {
        const SurfaceTriangle t = data_.triangle(i);
        const NearestOnTriangle found = nearest_on(t, center_);
        const double sq = (found.point - center_).squaredNorm();
        if (sq > nearest_sq || (sq == nearest_sq && i > through)) return;
        nearest_sq = sq;
        through = i;
        exit = found.point;
        // Nearest to an edge or a corner: straight out there.
        const bool on_face = found.feature.kind == PrismFeature::FACE ||
                             sq <= tolerance::coincident * tolerance::coincident * size_ * size_;
        normal = on_face ? t.normal : Vec3((exit - center_) / std::sqrt(sq));
      });
    }
    if (through < 0) return;
    Manifold plane;
    leaf_contacts(shape_, at_, Shape(HalfSpace{normal, normal.dot(exit)}), Placement{}, margin_,
                  plane);
    for (int i = 0; i < plane.size(); ++i) {
      points_.push_back(plane[i]);
      points_.back().feature_b =
          surface_feature(FeatureType::FACE, data_.triangle(through).patch_id);
    }
  }

  // A point behind this triangle may have come in through another one: then it is much less deep
  // there, and moved out there it is no longer over this triangle.
  bool better_exit(const SurfaceTriangle& t, const Vec3& p, double depth) const {
    for (const SurfaceTriangle& other : triangles_) {
      if (other.face_id == t.face_id || !in_front(other)) continue;
      const double here = other.normal.dot(other.corner[0] - p);
      if (!(here >= 0.0 && here < 0.5 * depth) || !projects_into(other, p, 1e-12 * size_)) continue;
      const Vec3 out = p + here * other.normal;
      for (int k = 0; k < 3; ++k) {
        if (outside(t, k, out) >= -1e-12 * size_) return true;
      }
    }
    return false;
  }

  // m: less is rounding, where the shape need not seem to meet the surface.
  double deep() const { return 1e-6 * size_; }

  // Is there a triangle between the centre of the shape and p, a point of it behind the surface? A
  // long body may reach around the surface's end instead, and touch nothing.
  bool came_through(const Vec3& p) const {
    return std::any_of(triangles_.begin(), triangles_.end(), [&](const SurfaceTriangle& t) {
      const double from = t.normal.dot(center_ - t.corner[0]), to = t.normal.dot(p - t.corner[0]);
      if (!(from >= 0.0 && to < 0.0)) return false;
      const Vec3 crossing = center_ + (from / (from - to)) * (p - center_);
      for (int k = 0; k < 3; ++k) {
        if (outside(t, k, crossing) > 1e-9 * size_) return false;
      }
      return true;
    });
  }

  bool meets(const SurfaceTriangle& t) const {
    static thread_local TrianglePrism prism;
    Manifold meeting;
    leaf_contacts(shape_, at_, prism.place(t, thin(t)), Placement{}, 0.0, meeting);
    return meeting.size() > 0;
  }

  // Convex edges and corners of the triangle against the shape.
  void touch_edges(const SurfaceTriangle& t) {
    const bool sharp = std::any_of(t.edge.begin(), t.edge.end(), [](EdgeType e) {
      return e == EdgeType::CONVEX || e == EdgeType::BOUNDARY;
    });
    if (!sharp) return;
    double longest = 0.0;
    for (int k = 0; k < 3; ++k) {
      longest = std::max(longest, (t.corner[(k + 1) % 3] - t.corner[k]).norm());
    }
    static thread_local TrianglePrism prism;
    const Shape& solid = prism.place(t, std::max(longest, size_));
    Manifold manifold;
    leaf_contacts(shape_, at_, solid, Placement{}, margin_, manifold);
    for (int i = 0; i < manifold.size(); ++i) {
      ManifoldPoint p = manifold[i];
      const PrismFeature feature = prism.feature(p.feature_b);
      if (feature.kind == PrismFeature::FACE || !admits(data_, t, feature, p.normal)) continue;
      if (p.separation < -deep() && !meets(t)) continue;
      p.feature_b = name(t, feature);
      keep(p);
    }
  }

  const Data& data_;
  const Shape& surface_;
  const Shape& shape_;
  const Pose& pose_;
  Placement at_;
  double margin_, size_;
  Vec3 center_;
  std::vector<SurfaceTriangle> triangles_;
  std::vector<ManifoldPoint> points_;
  std::optional<HalfSpace> plane_;  // of on_plane_
  Manifold on_plane_;
};

}  // namespace

void surface_contacts(const Shape& convex, const Pose& pose_convex, const Shape& surface,
                      const Pose& pose_surface, double margin, std::vector<Manifold>& out) {
  check_convex(convex, surface);
  out.clear();
  const Pose relative = pose_surface.inverse() * pose_convex;
  with_data(surface, [&](const auto& data) {
    Finder finder(data, surface, convex, relative, margin);
    reduce_by_normal(finder.contacts(), flat_angle, out);
  });
  const Mat3 rotation = pose_surface.orientation.toRotationMatrix();
  for (Manifold& manifold : out) {
    for (int i = 0; i < manifold.size(); ++i) {
      ManifoldPoint& p = manifold[i];
      p.point_a = rotation * p.point_a + pose_surface.position;
      p.point_b = rotation * p.point_b + pose_surface.position;
      p.normal = rotation * p.normal;
    }
  }
}

}  // namespace rb
