#include "collision/face_clip.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "collision/reduce.hpp"
#include "math/tolerances.hpp"

namespace rb {

namespace {

constexpr int none = -1;

// A corner of the clipped polygon: a corner of the incident face, of the reference face, of both
// (they coincide), or of neither (two edges cross).
struct Clipped {
  Vec3 point;
  int incident_corner = none;
  int reference_corner = none;
  int incident_edge = none;   // of a crossing
  int reference_edge = none;  // of a crossing
  // The edge to the next corner: of the reference face or of the incident face.
  bool next_on_reference = false;
  int next_edge = none;
};

int shared_corner(int edge, int other, int count) {
  // Edge i runs from corner i to corner i + 1.
  if ((edge + 1) % count == other) return other;
  if ((other + 1) % count == edge) return edge;
  return other;
}

// Where the polygon's edge from `from` to `to` meets the side plane of reference edge `side`.
Clipped crossing(const Clipped& from, const Vec3& to, double d_from, double d_to, int side,
                 int reference_size) {
  Clipped c;
  // Always interpolate from the inner end, so that direction of travel leaves no trace in the bits.
  c.point = d_from < d_to ? Vec3(from.point + (d_from / (d_from - d_to)) * (to - from.point))
                          : Vec3(to + (d_to / (d_to - d_from)) * (from.point - to));
  if (from.next_on_reference) {
    c.reference_corner = shared_corner(from.next_edge, side, reference_size);
  } else {
    c.incident_edge = from.next_edge;
    c.reference_edge = side;
  }
  return c;
}

// One pass of Sutherland-Hodgman; corners within `tolerance` of the plane stay as they are.
void clip_by_side(const std::vector<Clipped>& in, const Vec3& outward, const Vec3& on_plane,
                  int side, int reference_size, double tolerance, std::vector<Clipped>& out) {
  out.clear();
  const std::size_t n = in.size();
  if (n == 0) return;
  double d = outward.dot(in[0].point - on_plane);
  const double d_first = d;
  for (std::size_t i = 0; i < n; ++i) {
    const bool last = i + 1 == n;
    const Clipped& next = last ? in[0] : in[i + 1];
    const double d_next = last ? d_first : outward.dot(next.point - on_plane);
    if (d <= tolerance) {
      out.push_back(in[i]);
      if (d_next > tolerance) {
        if (d < -tolerance) {
          out.push_back(crossing(in[i], next.point, d, d_next, side, reference_size));
        }
        out.back().next_on_reference = true;
        out.back().next_edge = side;
      }
    } else if (d_next < -tolerance) {
      Clipped c = crossing(in[i], next.point, d, d_next, side, reference_size);
      c.next_on_reference = in[i].next_on_reference;
      c.next_edge = in[i].next_edge;
      out.push_back(c);
    }
    d = d_next;
  }
}

// Gives coincident features one canonical name: both corners before one corner before a crossing.
void name_coincident(const FacePolygon& reference, const FacePolygon& incident, double tolerance,
                     Clipped& c) {
  const double tolerance_sq = tolerance * tolerance;
  const auto near_reference = [&](int corner) {
    const Vec3 apart = c.point - reference.corners[corner].point;
    return (apart - apart.dot(reference.normal) * reference.normal).squaredNorm() <= tolerance_sq;
  };
  const auto near_incident = [&](int corner) {
    return (c.point - incident.corners[corner].point).squaredNorm() <= tolerance_sq;
  };
  if (c.incident_edge != none) {
    for (const int corner : {c.incident_edge, (c.incident_edge + 1) % incident.size}) {
      if (near_incident(corner)) c.incident_corner = corner;
    }
  } else if (c.incident_corner == none) {
    for (int corner = 0; corner < incident.size && c.incident_corner == none; ++corner) {
      if (near_incident(corner)) c.incident_corner = corner;
    }
  }
  for (int corner = 0; corner < reference.size && c.reference_corner == none; ++corner) {
    if (near_reference(corner)) c.reference_corner = corner;
  }
}

struct Features {
  std::uint32_t reference;
  std::uint32_t incident;
};

Features features_of(const Clipped& c, const FacePolygon& reference, const FacePolygon& incident) {
  const bool on_reference = c.reference_corner != none, on_incident = c.incident_corner != none;
  if (on_reference || on_incident) {
    return {on_reference ? reference.corners[c.reference_corner].vertex : reference.face,
            on_incident ? incident.corners[c.incident_corner].vertex : incident.face};
  }
  return {reference.corners[c.reference_edge].edge, incident.corners[c.incident_edge].edge};
}

// Which of the incident corners are lowest: a face, an edge or a vertex lies on the reference
// plane.
ContactKind lowest_feature(const FacePolygon& reference, const FacePolygon& incident,
                           double& highest_member) {
  const double cosine = reference.normal.dot(incident.normal);
  const Vec3 across = incident.normal - cosine * reference.normal;
  highest_member = std::numeric_limits<double>::infinity();
  if (across.squaredNorm() <= tolerance::parallel * tolerance::parallel) {
    return ContactKind::FACE_FACE;
  }
  const Vec3& on_plane = reference.corners[0].point;
  int lowest = 0;
  double lowest_height = std::numeric_limits<double>::infinity();
  for (int i = 0; i < incident.size; ++i) {
    const double height = reference.normal.dot(incident.corners[i].point - on_plane);
    if (height < lowest_height) {
      lowest_height = height;
      lowest = i;
    }
  }
  const Vec3& low = incident.corners[lowest].point;
  const int after = (lowest + 1) % incident.size;
  const int before = (lowest + incident.size - 1) % incident.size;
  for (const int other : {after, before}) {
    const Vec3 edge = incident.corners[other].point - low;
    const double rise = reference.normal.dot(edge);
    const double allowed = tolerance::parallel * edge.norm();
    if (rise <= allowed) {
      highest_member = lowest_height + allowed;
      return ContactKind::EDGE_FACE;
    }
  }
  return ContactKind::VERTEX_FACE;
}

}  // namespace

void clip_faces(const FacePolygon& reference, const FacePolygon& incident, bool reference_is_b,
                double margin, double tolerance, Manifold& out) {
  struct Memory {
    std::vector<Clipped> polygon, scratch;
    std::vector<ManifoldPoint> points;
  };
  static thread_local Memory memory;
  auto& [polygon, scratch, points] = memory;  // found once: each use asks for the thread
  polygon.clear();
  for (int i = 0; i < incident.size; ++i) {
    Clipped c;
    c.point = incident.corners[i].point;
    c.incident_corner = i;
    c.next_edge = i;
    polygon.push_back(c);
  }
  const Vec3& n = reference.normal;
  for (int side = 0; side < reference.size; ++side) {
    const Vec3& corner = reference.corners[side].point;
    const Vec3& next = reference.corners[side + 1 == reference.size ? 0 : side + 1].point;
    const Vec3 outward = (next - corner).cross(n).normalized();
    clip_by_side(polygon, outward, corner, side, reference.size, tolerance, scratch);
    polygon.swap(scratch);
  }

  double highest_member;
  const ContactKind lowest = lowest_feature(reference, incident, highest_member);
  points.clear();
  for (Clipped& c : polygon) {
    const double separation = n.dot(c.point - reference.corners[0].point);
    if (!(separation <= margin)) continue;
    name_coincident(reference, incident, tolerance, c);
    const Features features = features_of(c, reference, incident);
    const Vec3 below = c.point - separation * n;
    ManifoldPoint p;
    p.separation = separation;
    p.kind = lowest == ContactKind::EDGE_FACE && separation > highest_member
                 ? ContactKind::VERTEX_FACE
                 : lowest;
    if (reference_is_b) {
      p.point_a = c.point;
      p.point_b = below;
      p.normal = n;
      p.feature_a = features.incident;
      p.feature_b = features.reference;
      p.normal_owner = NormalOwner::B;
    } else {
      p.point_a = below;
      p.point_b = c.point;
      p.normal = -n;
      p.feature_a = features.reference;
      p.feature_b = features.incident;
      p.normal_owner = NormalOwner::A;
    }
    const auto same = [&](const ManifoldPoint& q) {
      return q.feature_a == p.feature_a && q.feature_b == p.feature_b;
    };
    if (std::none_of(points.begin(), points.end(), same)) points.push_back(p);
  }
  reduce(points, n, out);
}

void add_beside_crossing(const Manifold& corners, const Vec3& normal, double size, Manifold& out) {
  constexpr double beside = 0.02;
  const ManifoldPoint crossing = out[out.size() - 1];
  const double apart = beside * size;
  for (int i = 0; i < corners.size(); ++i) {
    const Vec3 offset = corners[i].point_a - crossing.point_a;
    const bool same =
        corners[i].feature_a == crossing.feature_a && corners[i].feature_b == crossing.feature_b;
    if (same || corners[i].separation < crossing.separation) continue;
    if ((offset - offset.dot(normal) * normal).norm() > apart) out.add(corners[i]);
  }
}

}  // namespace rb
