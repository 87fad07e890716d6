// The least impulses (sum of squares) that give the same motion: redundant contacts share evenly.
//
// Given a solution, v is known, and with it the face F_i of K_i that Coulomb's law leaves to each
// impulse: {0} where the contact opens, a ray where it slides, K_i where it sticks. Then
//   minimise sum |lambda_i|^2 / 2   subject to   J^T lambda = M (v - v_free),  lambda_i in F_i
// has the dual solution lambda_i = P_Fi(J_i y), found by Newton for the body vector y: the
// certificate. Moments count divided by FrictionCone::length.
#pragma once

#include <vector>

#include "contact/problem.hpp"
#include "solver/body_space.hpp"
#include "solver/friction_cone.hpp"

namespace rb {

struct MinimumNormWorkspace {
  std::vector<ConeFace> faces;
  std::vector<Reaction> argument, argument_step, reaction;
  std::vector<ReactionDerivative> d;
  std::vector<Vec6> target, dz, y, y_step, wrench;
};

// Faces left by the slip of v; slips below `threshold` (m/s) count as zero.
void cone_faces(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                const std::vector<Vec6>& v, double threshold, std::vector<ConeFace>& faces);
void cone_faces(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                const std::vector<Vec6>& v, const std::vector<Vec3>& slips, double threshold,
                std::vector<ConeFace>& faces);  // slips: u of every contact at v, m/s

// True if impulses are P_F(J y) to `tolerance` of the largest impulse: they are the least.
bool is_minimum_norm(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                     const std::vector<ConeFace>& faces, const std::vector<Vec3>& impulse,
                     const std::vector<Vec3>& moment, const std::vector<Vec6>& certificate,
                     double tolerance);

// Replaces impulse and moment by the least ones on ws.faces and writes the certificate, from whose
// old value it starts if that is near: another start leads to the same end. Returns the
// number of Newton steps, negative (nothing changed) if it did not converge. `eps` as in
// cone_newton, so that its last factorisation serves again where nothing slides.
int minimum_norm(const ContactProblem& problem, const std::vector<FrictionCone>& cones, double eps,
                 BodySpace& space, MinimumNormWorkspace& ws, std::vector<Vec3>& impulse,
                 std::vector<Vec3>& moment, std::vector<Vec6>& certificate);

// For a start that is nearly the answer: takes out what the slips of v still say where ws.faces
// stick, by least impulses, in two linear solves. False (nothing changed) where contacts slide or
// carry moments, or the impulses are not those of the certificate to `tolerance` of the largest.
bool refine_minimum_norm(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                         double eps, double tolerance, const std::vector<Vec6>& v, BodySpace& space,
                         MinimumNormWorkspace& ws, std::vector<Vec3>& impulse,
                         std::vector<Vec6>& certificate);

// Its parts. The impulses that a certificate of another geometry stands for in this one, on
// ws.faces; none of them slides.
void take_certificate(const ContactProblem& problem, const std::vector<FrictionCone>& cones,
                      const std::vector<Vec6>& certificate, MinimumNormWorkspace& ws,
                      std::vector<Vec3>& impulse);
// What the slips of v (m/s) ask for where the impulses, those of the certificate, may change
// freely (ws.d). False (nothing changed) if the matrix is singular.
bool stop_slips(const ContactProblem& problem, const std::vector<FrictionCone>& cones, double eps,
                const std::vector<Vec6>& v, BodySpace& space, MinimumNormWorkspace& ws,
                std::vector<Vec3>& impulse, std::vector<Vec6>& certificate);

}  // namespace rb
