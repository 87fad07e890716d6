#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "collision/queries.hpp"
#include "shape/height_field.hpp"
#include "shape/hull.hpp"
#include "shape/mesh.hpp"

namespace rb {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// A hit in body coordinates.
struct Hit {
  double distance;
  Vec3 normal;
};
using MaybeHit = std::optional<Hit>;

// The part of the ray inside an intersection of slabs, cylinders and half-spaces.
struct Interval {
  double enter = -infinity;
  double leave = infinity;
  Vec3 normal = Vec3::Zero();

  void clip(double from, double to, const Vec3& entered_through) {
    if (from > enter) {
      enter = from;
      normal = entered_through;
    }
    leave = std::min(leave, to);
  }
  // Keeps n . x <= offset.
  void clip_plane(const Vec3& n, double offset, const Vec3& o, const Vec3& d) {
    const double height = n.dot(o) - offset, speed = n.dot(d);
    if (speed < 0.0) {
      clip(-height / speed, infinity, n);
    } else if (speed > 0.0) {
      leave = std::min(leave, -height / speed);
    } else if (height > 0.0) {
      leave = -infinity;
    }
  }
  MaybeHit hit(const Vec3& direction) const {
    if (enter > leave || leave < 0.0) return {};
    if (enter < 0.0) return Hit{0.0, -direction};  // starts inside
    return Hit{enter, normal};
  }
};

// Inside a ball about `center`. The nearest point of the line is computed first: no cancellation in
// the discriminant when the ray starts far away.
MaybeHit ball(const Vec3& center, double radius, const Vec3& o, const Vec3& d) {
  const Vec3 m = o - center;
  if (m.squaredNorm() <= radius * radius) return Hit{0.0, -d};
  const double along = -m.dot(d);
  const Vec3 nearest = m + along * d;
  const double half_sq = radius * radius - nearest.squaredNorm();
  if (along < 0.0 || half_sq < 0.0) return {};
  const double t = along - std::sqrt(half_sq);
  return Hit{t, (nearest + (t - along) * d).normalized()};
}

// Inside the infinite cylinder about z.
void clip_tube(Interval& inside, double radius, const Vec3& o, const Vec3& d) {
  const Vec2 m = o.head<2>(), u = d.head<2>();
  const double speed_sq = u.squaredNorm();
  if (speed_sq == 0.0) {
    if (m.squaredNorm() > radius * radius) inside.leave = -infinity;
    return;
  }
  const double along = -m.dot(u) / speed_sq;
  const Vec2 nearest = m + along * u;
  const double half_sq = (radius * radius - nearest.squaredNorm()) / speed_sq;
  if (half_sq < 0.0) {
    inside.leave = -infinity;
    return;
  }
  const double half = std::sqrt(half_sq);
  const Vec2 n = (nearest - half * u).normalized();
  inside.clip(along - half, along + half, Vec3(n.x(), n.y(), 0.0));
}

struct Cast {
  const Vec3& o;  // body coordinates
  const Vec3& d;  // unit

  MaybeHit operator()(const Particle&) const { return {}; }  // a point has no area to hit
  MaybeHit operator()(const Sphere& s) const { return ball(Vec3::Zero(), s.radius, o, d); }
  MaybeHit operator()(const HalfSpace& s) const {
    Interval inside;
    inside.clip_plane(s.normal, s.offset, o, d);
    return inside.hit(d);
  }
  MaybeHit operator()(const Box& s) const {
    Interval inside;
    for (int k = 0; k < 3; ++k) {
      inside.clip_plane(Vec3::Unit(k), s.half_extents[k], o, d);
      inside.clip_plane(-Vec3::Unit(k), s.half_extents[k], o, d);
    }
    return inside.hit(d);
  }
  MaybeHit operator()(const Cylinder& s) const {
    Interval inside;
    clip_tube(inside, s.radius, o, d);
    inside.clip_plane(Vec3::UnitZ(), s.half_length, o, d);
    inside.clip_plane(-Vec3::UnitZ(), s.half_length, o, d);
    return inside.hit(d);
  }
  MaybeHit operator()(const Capsule& s) const {
    const Vec3 end(0.0, 0.0, s.half_length);
    MaybeHit best = middle(s);
    for (const Vec3& center : {end, Vec3(-end)}) {
      const MaybeHit hit = ball(center, s.radius, o, d);
      if (hit && (!best || hit->distance < best->distance)) best = hit;
    }
    return best;
  }
  MaybeHit operator()(const ConvexHull& s) const {
    Interval inside;
    for (const HullFace& face : s.data->faces) inside.clip_plane(face.normal, face.offset, o, d);
    return inside.hit(d);
  }
  MaybeHit operator()(const TriangleMesh& s) const;
  MaybeHit operator()(const HeightField& s) const;
  MaybeHit operator()(const Compound& s) const {
    MaybeHit best;
    for (const CompoundPart& part : s.data->parts) {
      const Vec3 origin = part.pose.apply_inverse(o), direction = part.pose.rotate_inverse(d);
      const MaybeHit hit = std::visit(Cast{origin, direction}, part.shape);
      if (hit && (!best || hit->distance < best->distance)) {
        best = Hit{hit->distance, part.pose.rotate(hit->normal)};
      }
    }
    return best;
  }

 private:
  // A capsule's middle: a hit through its flat ends is inside the balls and loses against theirs.
  MaybeHit middle(const Capsule& s) const { return (*this)(Cylinder{s.radius, s.half_length}); }
};

// Where the ray crosses the triangle's plane, if that is in the triangle. A little room at the
// edges: a ray must not slip through the seam of two triangles.
void cross(const SurfaceTriangle& t, const Vec3& o, const Vec3& d, MaybeHit& best) {
  const double speed = t.normal.dot(d);
  if (speed == 0.0) return;
  const double distance = t.normal.dot(t.corner[0] - o) / speed;
  if (!(distance >= 0.0) || (best && distance >= best->distance)) return;
  const Vec3 p = o + distance * d;
  for (int k = 0; k < 3; ++k) {
    const Vec3 e = t.corner[(k + 1) % 3] - t.corner[k];
    if (e.cross(t.normal).dot(p - t.corner[k]) > 1e-12 * e.squaredNorm()) return;
  }
  best = Hit{distance, t.normal};
}

MaybeHit Cast::operator()(const TriangleMesh& s) const {
  MaybeHit best;
  s.data->bvh.walk(
      [&](const Aabb& box) { return ray_meets(box, o, d, best ? best->distance : infinity); },
      [&](std::int32_t i) { cross(s.data->triangle(i), o, d, best); });
  return best;
}

MaybeHit Cast::operator()(const HeightField& s) const {
  const HeightData& field = *s.data;
  MaybeHit best;
  const Aabb all = field.bounds();
  if (!ray_meets(all, o, d, infinity)) return best;
  Interval inside;
  for (int k = 0; k < 3; ++k) {
    inside.clip_plane(Vec3::Unit(k), all.upper[k], o, d);
    inside.clip_plane(-Vec3::Unit(k), -all.lower[k], o, d);
  }
  // Strip by strip along x: the ray's part in the strip, boxed.
  const double start = std::max(inside.enter, 0.0), end = std::max(inside.leave, start);
  const double pad = 1e-9 * field.size;
  for (int i = 0; i + 1 < field.rows; ++i) {
    const double x0 = i * field.spacing.x(), x1 = x0 + field.spacing.x();
    double enter = start, leave = end;
    if (d.x() != 0.0) {
      const double t0 = (x0 - o.x()) / d.x(), t1 = (x1 - o.x()) / d.x();
      enter = std::max(start, std::min(t0, t1));
      leave = std::min(end, std::max(t0, t1));
    } else if (o.x() < x0 - pad || o.x() > x1 + pad) {
      continue;
    }
    if (enter > leave + pad || (best && enter > best->distance)) continue;
    const Vec3 p = o + enter * d, q = o + std::max(enter, leave) * d;
    Aabb strip{p.cwiseMin(q).array() - pad, p.cwiseMax(q).array() + pad};
    strip.lower.x() = strip.upper.x() = 0.5 * (x0 + x1);
    field.for_each_triangle(strip, [&](std::int32_t t) { cross(field.triangle(t), o, d, best); });
  }
  return best;
}

}  // namespace

std::optional<RayHit> ray_cast(const Shape& shape, const Pose& pose, const Vec3& origin,
                               const Vec3& direction) {
  const double length = direction.norm();
  if (!origin.allFinite() || !(length > 0.0) || !std::isfinite(length)) {
    throw std::invalid_argument("ray_cast: origin must be finite, direction finite and not zero");
  }
  const Vec3 d = direction / length;
  const Vec3 local_origin = pose.apply_inverse(origin), local_direction = pose.rotate_inverse(d);
  const MaybeHit hit = std::visit(Cast{local_origin, local_direction}, shape);
  if (!hit) return {};
  return RayHit{hit->distance, origin + hit->distance * d, pose.rotate(hit->normal)};
}

}  // namespace rb
