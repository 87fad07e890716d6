// Contact time of a convex shape with a mesh or height field: of the triangles in its way, the one
// that nothing is known to clear longest is looked at first, so that the first impact found is the
// earliest.
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "collision/certified_search.hpp"
#include "collision/extent.hpp"
#include "collision/iteration_caps.hpp"
#include "collision/moving_pair.hpp"
#include "collision/surface_data.hpp"
#include "collision/surface_features.hpp"
#include "collision/sweep.hpp"
#include "collision/triangle_prism.hpp"

namespace rb {
namespace {

constexpr int least_queries = 20000;   // all triangles together may have at least so many
constexpr int max_false_impacts = 16;  // per triangle
constexpr int many_triangles = 256;    // worth a shorter look ahead

// Is the contact of the shape with this triangle one the surface would report? At inner edges it
// isn't; and a shape that comes sliding over an inner edge meets the next face without sinking into
// it.
template <class Data>
bool is_impact(const Data& data, const SurfaceTriangle& t, const Shape& convex, const Pose& pose,
               const Pose& later, const Shape& solid, const TrianglePrism& prism, double size) {
  Manifold manifold;
  leaf_contacts(convex, {pose.orientation.toRotationMatrix(), pose.position}, solid, Placement{},
                1e-7 * size, manifold);
  const bool sinks =
      extent(convex, later, -t.normal) > extent(convex, pose, -t.normal) + 1e-13 * size;
  for (int i = 0; i < manifold.size(); ++i) {
    const PrismFeature feature = prism.feature(manifold[i].feature_b);
    const bool along_face = manifold[i].normal.dot(t.normal) > 1.0 - flat_angle;
    if (admits(data, t, feature, manifold[i].normal) && (!along_face || sinks)) return true;
  }
  return manifold.size() == 0;  // can't tell: better one stop too many
}

template <class Data>
class SurfaceSearch {
 public:
  SurfaceSearch(const Data& data, const Shape& surface, const Sweep& motion_surface,
                const Shape& convex, const Sweep& motion_convex, double t_max, int most_queries)
      : data_(data),
        convex_(convex),
        motion_(motion_convex),
        ground_(motion_surface),
        t_max_(t_max),
        most_queries_(most_queries),
        size_(characteristic_size(convex)),
        radius_(bounding_radius(convex,
                                motion_convex.about_center(0.0).apply_inverse(Vec3(Vec3::Zero())))),
        velocity_(motion_convex.linear_velocity() - motion_surface.linear_velocity()),
        acceleration_(motion_convex.linear_acceleration() - motion_surface.linear_acceleration()),
        flight_(motion_convex),
        ground_flight_(motion_surface),
        ball_(Sphere{radius_}),
        ground_ball_(Sphere{bounding_radius(
            surface, motion_surface.about_center(0.0).apply_inverse(Vec3(Vec3::Zero())))}),
        balls_(ball_, flight_, ground_ball_, ground_flight_, t_max) {}

  // Looks ahead as far as the triangles in the way are few, then further.
  ImpactSearch run() {
    const double horizon = balls_.horizon();
    double from = 0.0, span = horizon;
    std::vector<std::int32_t> in_the_way;
    while (!is_known_) {
      from = balls_.apart_until(from);
      if (from >= t_max_) break;
      if (from >= horizon) {
        give_up_at(from);
        break;
      }
      double to = std::min(from + span, horizon);
      while (!gather(from, to, in_the_way)) {
        span = 0.5 * (to - from);
        to = from + span;
      }
      look(in_the_way, from, to);
      from = to;
      span *= 2.0;
    }
    return result_;
  }

 private:
  // A triangle and the search on it. Prisms share one hull, placed where it is looked at.
  struct Candidate {
    SurfaceTriangle triangle;
    std::unique_ptr<MovingPair> pair;
    std::unique_ptr<CertifiedSearch> search;
    int false_impacts = 0;
  };

  double travel(double from, double to) const {
    const Vec3 middle = velocity_ + 0.5 * (from + to) * acceleration_;
    return (to - from) * (middle.norm() + 0.5 * (to - from) * acceleration_.norm());
  }

  // The triangles the shape may meet from one time to another. False where they are many: then not
  // all of them.
  bool gather(double from, double to, std::vector<std::int32_t>& triangles) const {
    triangles.clear();
    bool few = true;
    const bool may_shorten = travel(from, to) > radius_;
    data_.for_each_triangle(swept_box(from, to), [&](std::int32_t i) {
      if (may_shorten && static_cast<int>(triangles.size()) >= many_triangles) {
        few = false;
      } else {
        triangles.push_back(i);
      }
    });
    return few;
  }

  // Surface coordinates that hold the shape all the while.
  Aabb swept_box(double from, double to) const {
    const double span = to - from;
    const Vec3 start = ground_.at(from).apply_inverse(motion_.center(from));
    const Vec3 end = ground_.at(to).apply_inverse(motion_.center(to));
    double room = radius_ + 1e-9 * size_;
    // How far a parabola leaves its chord.
    room += 0.125 * span * span * acceleration_.norm();
    const double turn = ground_.max_angular_speed() * span;
    if (turn > 0.0) {  // a turning surface: hold everything it may sweep over
      room += turn * ((motion_.center(from) - ground_.center(from)).norm() + travel(from, to));
    }
    return {start.cwiseMin(end).array() - room, start.cwiseMax(end).array() + room};
  }

  void look(std::vector<std::int32_t>& in_the_way, double from, double to) {
    std::vector<Candidate> candidates;
    candidates.reserve(in_the_way.size());
    for (const std::int32_t i : in_the_way) {
      candidates.push_back({data_.triangle(i), nullptr, nullptr, 0});
    }
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
      return a.triangle.face_id < b.triangle.face_id;
    });
    // A heap of those still open, the least advanced on top; of equals the first.
    struct Open {
      double reached;  // s, nothing met before
      std::size_t index;
      bool operator<(const Open& other) const {
        return reached != other.reached ? reached > other.reached : index > other.index;
      }
    };
    std::vector<Open> open;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      Candidate& c = candidates[i];
      search_from(c, from, to);
      const double clear = c.pair->apart_until(from);
      if (clear < to) open.push_back({clear, i});
    }
    std::make_heap(open.begin(), open.end());
    const auto reopen = [&](std::size_t index, double time) {
      open.push_back({time, index});
      std::push_heap(open.begin(), open.end());
    };
    while (!open.empty()) {
      std::pop_heap(open.begin(), open.end());
      const std::size_t index = open.back().index;
      open.pop_back();
      const double next = open.empty() ? to : open.front().reached;
      Candidate& c = candidates[index];
      if (c.search->is_over()) {  // and nobody else's may come before
        const double time = *c.search->result().time;
        if (c.search->result().converged && is_behind(c, time)) {
          c.triangle = turned_over(c.triangle);
          ++c.false_impacts;
          search_from(c, time, to);
          reopen(index, time);
          continue;
        }
        if (c.search->result().converged && is_false(c, time)) {
          const double later = time + std::max(1e-3 * (to - time), 1e-12 * t_max_);
          ++c.false_impacts;
          if (!(later < to)) continue;
          c.search = std::make_unique<CertifiedSearch>(*c.pair, later, most_queries_);
          reopen(index, later);
          continue;
        }
        result_.time = time;
        result_.converged = c.search->result().converged;
        is_known_ = true;
        return;
      }
      prism_.place(c.triangle, thin(c.triangle));
      const int before = c.search->result().iterations;
      c.search->run(next);
      result_.iterations += c.search->result().iterations - before;
      if (c.search->is_over() && !c.search->result().time) continue;
      reopen(index, c.search->is_over() ? *c.search->result().time : c.search->reached());
      if (result_.iterations >= std::max(most_queries_, least_queries)) {
        give_up_at(open.front().reached);
        return;
      }
    }
  }

  void search_from(Candidate& c, double from, double to) {
    const Shape& solid = prism_.place(c.triangle, thin(c.triangle));
    c.pair = std::make_unique<MovingPair>(convex_, motion_, solid, ground_, to);
    c.search = std::make_unique<CertifiedSearch>(*c.pair, from, most_queries_);
  }

  // Does the shape come to a sheet from the side on which the triangle's prism is? A particle keeps
  // to the front.
  bool is_behind(const Candidate& c, double time) const {
    if (!is_sheet(data_) || std::holds_alternative<Particle>(convex_)) return false;
    if (c.false_impacts >= max_false_impacts) return false;
    const Vec3 center = center_of(convex_, ground_.at(time).inverse() * motion_.at(time));
    return c.triangle.normal.dot(center - c.triangle.corner[0]) < 0.0;
  }

  void give_up_at(double time) {
    count_iteration_cap();
    result_.time = time;
    result_.converged = false;
    is_known_ = true;
  }

  bool is_false(const Candidate& c, double time) {
    if (c.false_impacts >= max_false_impacts) return false;
    const Shape& solid = prism_.place(c.triangle, thin(c.triangle));
    const double soon = time + 1e-4 * t_max_;
    const Pose pose = ground_.at(time).inverse() * motion_.at(time);
    const Pose later = ground_.at(soon).inverse() * motion_.at(soon);
    return !is_impact(data_, c.triangle, convex_, pose, later, solid, prism_, size_);
  }

  const Data& data_;
  const Shape& convex_;
  const Sweep& motion_;
  const Sweep& ground_;
  double t_max_;
  int most_queries_;
  double size_, radius_;
  Vec3 velocity_, acceleration_;  // of the shape's centre seen from the surface's
  CenterSweep flight_, ground_flight_;
  Shape ball_, ground_ball_;
  MovingPair balls_;  // that hold the shape and the surface, however they turn
  TrianglePrism prism_;
  ImpactSearch result_;
  bool is_known_ = false;
};

}  // namespace

ImpactSearch surface_time_of_impact(const Shape& convex, const Sweep& motion_convex,
                                    const Shape& surface, const Sweep& motion_surface, double t_max,
                                    int most_queries) {
  return with_data(surface, [&](const auto& data) {
    return SurfaceSearch(data, surface, motion_surface, convex, motion_convex, t_max, most_queries)
        .run();
  });
}

}  // namespace rb
