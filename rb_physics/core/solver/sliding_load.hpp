// Of all answers where contacts slide, the one that does not depend on their order.
//
// Redundant contacts that slide along different directions (a box that turns as it slides) have
// many answers, and not only their forces differ: the motion does. The one chosen is the limit of a
// vanishing compliance, W + eps I with eps -> 0: what Coulomb's law leaves free (normal impulses,
// and tangential ones where contacts stick) is J y of some body vector y, the least that bears the
// same load. Newton's proximal steps move along J y only, so they keep it.
#pragma once

#include <vector>

#include "contact/problem.hpp"
#include "solver/body_space.hpp"
#include "solver/minimum_norm.hpp"

namespace rb {

struct SlidingLoadWorkspace {
  std::vector<ConeFace> faces;
  std::vector<FrictionCone> held;
  std::vector<Vec3> impulse, moment;
  std::vector<Vec6> certificate;
};

// Replaces what is free of impulse and moment by the least of equal load; sliding components follow
// at their bounds. ws.faces: the faces left by the slip (cone_faces). `eps` as in minimum_norm.
// Returns the largest relative change of an impulse; 0 if nothing slides or it did not converge.
double even_sliding_load(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                         double eps, BodySpace& space, MinimumNormWorkspace& ws,
                         SlidingLoadWorkspace& own, std::vector<Vec3>& impulse,
                         std::vector<Vec3>& moment);

}  // namespace rb
