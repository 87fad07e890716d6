#include "world/seams.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <variant>

#include "collision/extent.hpp"
#include "math/tolerances.hpp"

namespace rb {
namespace {

// A contact as the one of its bodies that may slide feels it; `piece` is the other one's collider.
// What every plane is compared with is copied: the contacts of a heap do not fit into the cache.
struct View {
  View(Contact& c, bool b)
      : contact(&c),
        slider_is_b(b),
        collider(b ? c.collider_a : c.collider_b),
        touch(c.touch),
        point(b ? c.point.point_a : c.point.point_b) {}

  Contact* contact;
  bool slider_is_b;
  std::int32_t collider;
  double touch;
  Vec3 point;

  std::int32_t piece() const { return collider; }
  std::int32_t piece_body() const { return slider_is_b ? contact->body_a : contact->body_b; }
  const Vec3& on_piece() const { return point; }
  const Vec3& on_slider() const {
    return slider_is_b ? contact->point.point_b : contact->point.point_a;
  }
  // To the slider.
  Vec3 normal() const { return slider_is_b ? Vec3(-contact->point.normal) : contact->point.normal; }
};

// The plane of a face between a body and one it meets: it separates the two.
struct Support {
  std::int32_t collider;
  std::int32_t body;  // row
  Vec3 normal;        // unit, to the slider
  double height;      // m, normal . x on the plane
  double separation;  // m, of the slider
  double touch;       // m
  bool of_slider;     // the face is the slider's own
};

// m: how far the collider reaches along the direction, or more.
double reach_along(const World& world, std::int32_t collider, const Vec3& direction) {
  const Collider& c = world.colliders[collider];
  const Pose pose = world.bodies[c.body].pose() * c.local;
  const bool surface =
      std::holds_alternative<TriangleMesh>(c.shape) || std::holds_alternative<HeightField>(c.shape);
  if (!surface) return extent(c.shape, pose, direction);
  const Aabb box = bounding_box(c.shape, Pose{});
  const Vec3 local = pose.rotate_inverse(direction);
  return direction.dot(pose.position) + 0.5 * local.dot(box.lower + box.upper) +
         0.5 * local.cwiseAbs().dot(box.upper - box.lower);
}

// The plane's own contacts, and those whose normal differs by rounding.
bool along(const View& v, const Vec3& normal) {
  constexpr double rounding = 1e-10;
  const bool centers = v.contact->point.normal_owner == NormalOwner::CENTERS;
  const double most = centers ? rounding : tolerance::parallel;
  return (v.normal() - normal).squaredNorm() <= most * most;
}

// m/s: of the point p of the body.
Vec3 velocity_at(const Body& body, const Vec3& p) {
  return body.linear_velocity() + body.angular_velocity().cross(p - body.state.x);
}

// `by_motion` is set where that depends on velocities.
bool covers(const World& world, const Support& s, const View& v, bool& by_motion) {
  if (s.collider == v.piece()) return false;
  const Vec3& p = v.on_piece();
  const double level = s.touch + v.touch;
  const double above = s.normal.dot(p) - s.height;
  if (above > level || above < std::fmin(0.0, s.separation) - level) return false;
  if (along(v, s.normal)) return false;
  if (reach_along(world, v.piece(), s.normal) > s.height + level) return false;
  if (s.body == v.piece_body()) return true;
  by_motion = true;
  // They stay level over the next step.
  const Body &plane = world.bodies[s.body], &piece = world.bodies[v.piece_body()];
  const double rising = s.normal.dot(velocity_at(piece, p) - velocity_at(plane, p));
  return world.settings.dt * std::fabs(rising) <= level;
}

// Makes the contact one with the plane: all that the slider can meet there from above.
void lift(const World& world, const Support& s, const View& v) {
  Contact& c = *v.contact;
  c.lifted = true;
  const Vec3 on_slider = v.on_slider();
  const double height = s.normal.dot(on_slider) - s.height;
  const Vec3 on_plane = on_slider - height * s.normal;
  c.point.normal = v.slider_is_b ? Vec3(-s.normal) : s.normal;
  c.point.separation = height;
  c.point.point_a = v.slider_is_b ? on_plane : on_slider;
  c.point.point_b = v.slider_is_b ? on_slider : on_plane;
  c.point.normal_owner = s.of_slider == v.slider_is_b ? NormalOwner::B : NormalOwner::A;
  c.local_a = world.bodies[c.body_a].pose().apply_inverse(c.point.point_a);
  c.local_b = world.bodies[c.body_b].pose().apply_inverse(c.point.point_b);
}

// One plane for every pair of faces.
void find_supports(const std::vector<View>& views, std::vector<Support>& out) {
  out.clear();
  for (const View& v : views) {
    const Contact& c = *v.contact;
    if (c.point.normal_owner != NormalOwner::A && c.point.normal_owner != NormalOwner::B) continue;
    const Vec3 normal = v.normal();
    if (!out.empty() && out.back().collider == v.piece() &&
        (out.back().normal - normal).isZero(0.0)) {
      out.back().separation = std::fmin(out.back().separation, c.point.separation);
      continue;
    }
    out.push_back({v.piece(), v.piece_body(), normal, normal.dot(v.on_piece()), c.point.separation,
                   c.touch, (c.point.normal_owner == NormalOwner::B) == v.slider_is_b});
  }
}

// A particle on an edge of a piece touches all faces that meet there (collision/sphere_box.cpp).
// Those that another piece shuts are none: nothing fits between the two.
void cover_shut_faces(const std::vector<View>& views) {
  for (const View& v : views) {
    Contact& c = *v.contact;
    const double level = 2.0 * c.touch;
    const auto of_piece = [&](const View& other) { return other.piece() == v.piece(); };
    if (std::count_if(views.begin(), views.end(), of_piece) < 2) continue;
    const Vec3 n = v.normal();
    const bool shut = std::any_of(views.begin(), views.end(), [&](const View& other) {
      return !of_piece(other) &&
             (other.normal() + n).squaredNorm() <= tolerance::parallel * tolerance::parallel &&
             std::fabs(n.dot(other.on_piece() - v.on_piece())) <= level;
    });
    if (shut) c.role = ContactRole::COVERED;
  }
}

// Is any contact with the plane still felt? Two pieces of one corner must not cover each other.
bool is_felt(const Support& s, const std::vector<View>& views) {
  return std::any_of(views.begin(), views.end(), [&](const View& v) {
    return v.contact->role == ContactRole::ACTIVE && v.piece() == s.collider && along(v, s.normal);
  });
}

// The pairs of every collider that may slide, as lists linked through `next`: pair k, a run of
// contacts, is element 2 k of its A's list and 2 k + 1 of its B's, where B can move.
class Lists {
 public:
  void build(const World& world, std::vector<Contact>& contacts) {
    contacts_ = contacts.data();
    if (first_.size() < world.colliders.size()) first_.resize(world.colliders.size(), none);
    ends_.assign(1, 0);
    for (std::size_t i = 1; i <= contacts.size(); ++i) {
      contacts[i - 1].role = ContactRole::ACTIVE;
      if (i == contacts.size() || contacts[i].collider_a != contacts[i - 1].collider_a ||
          contacts[i].collider_b != contacts[i - 1].collider_b)
        ends_.push_back(static_cast<std::int32_t>(i));
    }
    next_.resize(2 * ends_.size());
    sliders.clear();
    for (std::size_t k = ends_.size() - 1; k-- > 0;) {  // from the back: the lists run in order
      const Contact& c = contacts[ends_[k]];
      link(c.collider_a, static_cast<std::int32_t>(2 * k));
      if (world.bodies[c.body_b].is_dynamic())
        link(c.collider_b, static_cast<std::int32_t>(2 * k + 1));
    }
  }

  // Empties the slider's list into `out`; false, and nothing there, when all of it is of one pair.
  bool take(std::int32_t slider, std::vector<View>& out) {
    out.clear();
    const std::int32_t first = first_[slider];
    first_[slider] = none;
    if (next_[first] == none) return false;
    for (std::int32_t e = first; e != none; e = next_[e]) {
      for (std::int32_t i = ends_[e / 2]; i < ends_[e / 2 + 1]; ++i)
        out.emplace_back(contacts_[i], e % 2 == 1);
    }
    return true;
  }

  std::vector<std::int32_t> sliders;  // colliders

 private:
  static constexpr std::int32_t none = -1;

  void link(std::int32_t collider, std::int32_t element) {
    if (first_[collider] == none) sliders.push_back(collider);
    next_[element] = first_[collider];
    first_[collider] = element;
  }

  Contact* contacts_ = nullptr;
  std::vector<std::int32_t> ends_;   // where pair k begins; then the end of the last one
  std::vector<std::int32_t> first_;  // per collider; all `none` between two uses
  std::vector<std::int32_t> next_;
};

}  // namespace

bool cover_seams(const World& world, std::vector<Contact>& contacts) {
  struct Lift {
    View view;
    Support plane;
  };
  struct Memory {
    Lists lists;
    std::vector<View> views;
    std::vector<Support> supports;
    std::vector<Lift> lifts;
  };
  static thread_local Memory memory;
  auto& [lists, views, supports, lifts] = memory;  // found once: each use asks for the thread
  lists.build(world, contacts);
  lifts.clear();
  bool by_motion = false;
  for (const std::int32_t slider : lists.sliders) {
    if (!lists.take(slider, views)) continue;
    const bool particle = std::holds_alternative<Particle>(world.colliders[slider].shape);
    if (particle) cover_shut_faces(views);
    find_supports(views, supports);
    for (const Support& s : supports) {
      if (particle && !is_felt(s, views)) continue;
      for (const View& v : views) {
        if (!covers(world, s, v, by_motion) || v.contact->role == ContactRole::COVERED) continue;
        if (s.normal.dot(v.on_slider()) - s.height <= s.touch + v.contact->touch) {
          v.contact->role = ContactRole::COVERED;
        } else {
          lifts.push_back({v, s});
        }
      }
    }
  }
  for (const Lift& l : lifts) {
    if (l.view.contact->role == ContactRole::ACTIVE) lift(world, l.plane, l.view);
  }
  return by_motion;
}

}  // namespace rb
