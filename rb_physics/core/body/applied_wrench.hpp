// A wrench applied from outside and held on a body until it is replaced, cleared or its time is
// over.
#pragma once

#include <cstdint>

#include "body/state.hpp"

namespace rb {

enum class WrenchFrame : std::uint8_t { WORLD = 0, BODY = 1 };

struct AppliedWrench {
  std::int32_t source = 0;  // the same source replaces its own wrench; several sources add up
  WrenchFrame frame = WrenchFrame::WORLD;
  bool at_center = true;       // acts at the centre of mass, else at `point`
  Vec3 force = Vec3::Zero();   // N, axes of `frame`
  Vec3 torque = Vec3::Zero();  // N m, axes of `frame`
  Vec3 point = Vec3::Zero();   // m, body coordinates; fixed to the body
  double remaining = -1.0;     // s of time left; negative: until replaced; 0: one step
};

// The wrench in world axes about the centre of mass. In `world` it keeps its direction, in `body`
// it turns.
inline Wrench in_world(const AppliedWrench& w, const Quat& q, const Vec3& center_of_mass) {
  Wrench out{w.force, w.torque};
  if (w.frame == WrenchFrame::BODY) {
    out.force = q * w.force;
    out.torque = q * w.torque;
  }
  if (!w.at_center) out.torque += (q * Vec3(w.point - center_of_mass)).cross(out.force);
  return out;
}

}  // namespace rb
