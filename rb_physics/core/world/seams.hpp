// Seams of a floor made of pieces: tiles, or parts of a compound, whose tops lie in one plane. A
// body that slides over such a floor is nearest to the side of the next piece shortly before it
// reaches it, across a gap that closes; yet it cannot run into a piece no point of which stands out
// of the plane it slides on. (Meshes keep their own seams: collision/surface_contacts.)
#pragma once

#include <vector>

#include "world/world.hpp"

namespace rb {

// Looks for contacts of a body and a piece where the body meets another piece face on, the plane of
// that face has all of the first piece on its far side, that piece touches the plane where the
// contact is and stays level with the other one, and the contact's normal is not the plane's.
// Lengths count as zero up to the touch distance. Where the body's point lies in the plane as well,
// the contact becomes COVERED; where it is above, its normal and separation become those to the
// plane. `contacts` are ordered by pair, none of them is a GHOST; all others become ACTIVE. False:
// the same contacts have the same seams whatever the velocities.
bool cover_seams(const World& world, std::vector<Contact>& contacts);

}  // namespace rb
