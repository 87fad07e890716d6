#include "collision/cylinder_axis.hpp"

#include <algorithm>
#include <cmath>

#include "collision/closest.hpp"
#include "math/tolerances.hpp"

namespace rb {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

// Separation of one rim from an edge along normals across it.
class RimArc {
 public:
  struct Sample {
    Vec3 n, w;          // w: from the edge's tail to the rim's point farthest against n, m
    double separation;  // m
    double slope;       // m/rad
  };

  RimArc(const PlacedCylinder& cylinder, const AxisEdge& edge, const Vec3& low, const Vec3& high)
      : cylinder_(cylinder),
        tail_(edge.tail),
        forward_(edge.along.dot(low.cross(high)) >= 0.0 ? edge.along : Vec3(-edge.along)),
        cap_(cylinder.cap_center(cylinder.axis.dot(low + high) <= 0.0)) {}

  Vec3 rim(const Vec3& n) const {
    Vec3 radial;
    return cylinder_.radial(n, radial) ? Vec3(cap_ - cylinder_.radius * radial) : cap_;
  }
  Sample at(const Vec3& n) const {
    const Vec3 w = rim(n) - tail_;
    return {n, w, n.dot(w), forward_.cross(n).dot(w)};
  }
  // The greatest separation between two samples whose slopes point at each other: Newton's method
  // within the bracket.
  Vec3 summit(Vec3 low, Vec3 high) const {
    const double noise =
        4.0 * epsilon * ((cap_ - tail_).norm() + cylinder_.radius + cylinder_.half);
    Vec3 n = (low + high).normalized();
    double slope_before = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 100; ++i) {
      const Sample here = at(n);
      if (std::abs(here.slope) <= noise) break;
      (here.slope > 0.0 ? low : high) = n;
      const Vec3 m = forward_.cross(n);
      const double bend = -here.separation - cylinder_.curvature(n, m, m);
      // Steps that bring little (near the axis a rim turns fast) give way to halving.
      const bool brisk = bend < 0.0 && std::abs(here.slope) < 0.5 * slope_before;
      const double step = brisk ? -here.slope / bend : 0.0;
      slope_before = std::abs(here.slope);
      if (step != 0.0 && std::abs(step) <= epsilon) break;
      Vec3 next = (n + step * m).normalized();
      if (!(forward_.dot(low.cross(next)) > 0.0 && forward_.dot(next.cross(high)) > 0.0)) {
        next = (low + high).normalized();
      }
      if (next == n) break;
      n = next;
    }
    return n;
  }

 private:
  const PlacedCylinder& cylinder_;
  Vec3 tail_, forward_, cap_;
};

}  // namespace

void CylinderAxisSearch::offer_flat(CylinderAxis::Kind kind, const Vec3& normal, double separation,
                                    int feature) {
  if (!(separation > flat_.separation + preference_)) return;
  flat_.kind = kind;
  flat_.normal = normal;
  flat_.separation = separation;
  flat_.feature = feature;
}

void CylinderAxisSearch::offer_crossing(const AxisEdge& edge, const Vec3& normal) {
  CylinderAxis axis;
  axis.separation = normal.dot(cylinder_.center - edge.tail) - cylinder_.radius - edge.radius;
  if (!(axis.separation > free_.separation)) return;
  Vec3 on_axis, on_edge;
  closest_on_lines(cylinder_.center, cylinder_.axis, edge.tail, edge.along, on_axis, on_edge);
  const double s = cylinder_.axis.dot(on_axis - cylinder_.center);
  const double t = edge.along.dot(on_edge - edge.tail);
  if (std::abs(s) > cylinder_.half + tolerance_) return;
  if (t < -tolerance_ || t > edge.length + tolerance_) return;
  axis.kind = CylinderAxis::CROSSING;
  axis.normal = normal;
  axis.feature = edge.feature;
  axis.on_cylinder = on_axis - cylinder_.radius * normal;
  axis.on_other = on_edge + edge.radius * normal;
  free_ = axis;
}

void CylinderAxisSearch::offer_crossing(const AxisEdge& edge, const Vec3& left, const Vec3& right) {
  if (!(cylinder_.axis.dot(left) * cylinder_.axis.dot(right) < 0.0)) return;
  const Vec3 cross = cylinder_.axis.cross(edge.along);
  const double length = cross.norm();
  if (length <= tolerance::parallel_edges) return;
  offer_crossing(edge,
                 cross.dot(left + right) >= 0.0 ? Vec3(cross / length) : Vec3(cross / -length));
}

void CylinderAxisSearch::offer_rim(const AxisEdge& edge, const Vec3& left, const Vec3& right) {
  // No arc may reach from one cap to the other, nor much beyond a right angle.
  if (left.dot(right) < -0.5) {
    const Vec3 across = edge.along.cross(left);
    const Vec3 unit =
        (left + right + (across.dot(right) >= 0.0 ? across : Vec3(-across))).normalized();
    offer_rim(edge, left, unit);
    offer_rim(edge, unit, right);
    return;
  }
  const double rise_left = cylinder_.axis.dot(left), rise_right = cylinder_.axis.dot(right);
  if (rise_left * rise_right < 0.0) {
    const Vec3 level = (rise_left * right - rise_right * left).normalized();
    const Vec3 between = rise_left > 0.0 ? level : Vec3(-level);
    climb_rim(edge, left, between);
    climb_rim(edge, between, right);
  } else {
    climb_rim(edge, left, right);
  }
}

// The side along a parallel edge, at the middle of the common part.
void CylinderAxisSearch::offer_beside(const AxisEdge& edge) {
  const PlacedCylinder& c = cylinder_;
  const double middle = edge.along.dot(c.center - edge.tail);
  const double low = std::max(0.0, middle - c.half);
  const double high = std::min(edge.length, middle + c.half);
  if (low > high + tolerance_) return;
  const Vec3 on_edge = edge.tail + 0.5 * (low + high) * edge.along;
  CylinderAxis axis;
  // On the axis any sideways direction is as good as another: x.
  const Vec3 apart = c.center - on_edge;
  const Vec3 aside = apart - edge.along.dot(apart) * edge.along;
  const double length = aside.norm();
  axis.normal = length > 0.0 ? Vec3(aside / length) : c.x;
  if (std::abs(c.axis.dot(axis.normal)) * c.half > 1e-3 * tolerance_) {
    offer_rim_point(edge, c(Vec3(-axis.normal)).point, axis.normal);
    return;
  }
  axis.separation = axis.normal.dot(c(Vec3(-axis.normal)).point - on_edge) - edge.radius;
  if (!(axis.separation > free_.separation)) return;
  axis.kind = CylinderAxis::RIM;
  axis.feature = edge.feature;
  axis.on_other = on_edge + edge.radius * axis.normal;
  axis.on_cylinder = axis.on_other + axis.separation * axis.normal;
  free_ = axis;
}

void CylinderAxisSearch::offer_free_edge(const AxisEdge& edge) {
  const Vec3 cross = cylinder_.axis.cross(edge.along);
  const double length = cross.norm();
  // x divides the normals that look at one cap from those that look at the other.
  const Vec3 x = length > 4.0 * epsilon ? Vec3(cross / length) : edge.along.unitOrthogonal();
  if (length > tolerance::parallel_edges) {
    offer_crossing(edge, x);
    offer_crossing(edge, Vec3(-x));
  }
  if (length <= tolerance::parallel) offer_beside(edge);
  const Vec3 y = edge.along.cross(x);
  climb_rim(edge, x, y);
  climb_rim(edge, y, -x);
  climb_rim(edge, -x, -y);
  climb_rim(edge, -y, x);
}

// Greatest separation of one rim from an edge over the arc of normals from `low` to `high`, on
// which the separation is smooth. Shapes that overlap may have several summits: the arc is halved
// until what is left lies below what is known.
void CylinderAxisSearch::climb_rim(const AxisEdge& edge, const Vec3& low, const Vec3& high) {
  const RimArc arc(cylinder_, edge, low, high);
  double reached = -std::numeric_limits<double>::infinity();
  // Where the separation is flat (concentric shapes) every direction is as good, and none is worth
  // a long search.
  int halvings = 100;
  const auto climb = [&](const auto& again, const RimArc::Sample& a,
                         const RimArc::Sample& b) -> void {
    reached = std::max({reached, a.separation, b.separation});
    if (a.separation >= 0.0 && a.slope <= 0.0) return;
    if (b.separation >= 0.0 && b.slope >= 0.0) return;
    if (a.separation < 0.0 && b.separation < 0.0 && a.n.dot(b.n) >= 0.0) {
      // The separation lies under its tangent planes.
      const double bound =
          std::min(std::max(a.separation, b.n.dot(a.w)), std::max(b.separation, a.n.dot(b.w)));
      if (bound <= reached + 0.1 * preference_ || useless(bound - edge.radius)) return;
    }
    if (a.slope > 0.0 && b.slope < 0.0) {
      const Vec3 n = arc.summit(a.n, b.n);
      offer_rim_point(edge, arc.rim(n), n);
      return;
    }
    if (halvings-- <= 0) return;
    const RimArc::Sample middle = arc.at((a.n + b.n).normalized());
    if (middle.slope == 0.0) offer_rim_point(edge, arc.rim(middle.n), middle.n);
    again(again, a, middle);
    again(again, middle, b);
  };
  const RimArc::Sample first = arc.at(low), last = arc.at(high);
  // A summit where two arcs meet belongs to neither.
  for (const RimArc::Sample* end : {&first, &last}) {
    if (end->slope == 0.0) offer_rim_point(edge, arc.rim(end->n), end->n);
  }
  climb(climb, first, last);
}

void CylinderAxisSearch::offer_rim_point(const AxisEdge& edge, const Vec3& on_rim, const Vec3& n) {
  const double t = edge.along.dot(on_rim - edge.tail);
  if (t < -tolerance_ || t > edge.length + tolerance_) return;
  CylinderAxis axis;
  axis.on_cylinder = on_rim;
  axis.on_other = edge.tail + t * edge.along + edge.radius * n;
  axis.separation = n.dot(axis.on_cylinder - axis.on_other);
  if (!(axis.separation > free_.separation)) return;
  // Nearly across the axis, rounding may have chosen the wrong rim.
  if (n.dot(axis.on_cylinder - cylinder_(Vec3(-n)).point) > 1e-3 * tolerance_) return;
  axis.kind = CylinderAxis::RIM;
  axis.normal = n;
  axis.feature = edge.feature;
  free_ = axis;
}

bool CylinderAxisSearch::at_corner(const Vec3& corner, CylinderAxis& axis) const {
  const Vec3 apart = cylinder_.center - corner;
  const double along = cylinder_.axis.dot(apart);
  const Vec3 radial = apart - along * cylinder_.axis;
  const double distance = radial.norm();
  if (!(distance > 0.0)) return false;
  const Vec3 inward = radial / distance;
  const double beyond_side = distance - cylinder_.radius;
  const double beyond_cap = std::abs(along) - cylinder_.half;
  axis.kind = CylinderAxis::CORNER;
  axis.on_other = corner;
  if (beyond_cap <= 0.0) {
    axis.normal = inward;
    axis.separation = beyond_side;
    axis.on_cylinder = corner + beyond_side * inward;
    return true;
  }
  if (beyond_side <= 0.0) return false;  // over a cap
  const Vec3 up = along > 0.0 ? cylinder_.axis : Vec3(-cylinder_.axis);
  const Vec3 gap = beyond_side * inward + beyond_cap * up;
  axis.separation = gap.norm();
  axis.normal = gap / axis.separation;
  axis.on_cylinder = corner + gap;
  return true;
}

}  // namespace rb
