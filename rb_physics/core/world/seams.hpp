// Seams of a floor made of pieces: tiles, or parts of a compound, whose tops lie in one plane. A
// body that slides over such a floor is nearest to the side of the next piece shortly before it
// reaches it, across a gap that closes; yet it cannot run into a piece no point of which stands out
// of the plane it slides on. (Meshes keep their own seams: collision/surface_contacts.)
#pragma once

#include <span>

#include "world/world.hpp"

namespace rb {

// Sets the role of every contact in `contacts` (ordered by pair, none of them a GHOST). COVERED or
// SHADED becomes a contact of A with an immovable B where A meets another immovable body or part
// face on, the plane of that face has all of B on its far side, B touches the plane where the
// contact is, and the contact's normal is not the plane's. Lengths count as zero up to the touch
// distance.
void cover_seams(const World& world, std::span<Contact> contacts);

}  // namespace rb
