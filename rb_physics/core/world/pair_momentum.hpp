// Displacements that separate bodies keep p and L of each, but not x x p: of two bodies displaced
// by +D / m_A and -D / m_B while they pass each other at v_A - v_B, the orbital angular momentum
// changes by D x (v_A - v_B). Where nothing immovable takes that up, the pair gives it back.
#pragma once

#include "body/body.hpp"
#include "contact/contact.hpp"

namespace rb {

// Takes `change` (N m s) from the angular momentum of the pair: it turns as one rigid body less
// fast, so that the contact's own relative velocity stays, and should that raise its kinetic
// energy, what moves inside of it slows down. Linear momentum stays. Booked as impulse and moments
// of the contact. Both bodies are dynamic.
void take_from_pair(Body& a, Body& b, Contact& contact, const Vec3& change);

}  // namespace rb
