// Counts queries of the calling thread whose iterations ran out (they still answer, less exactly).
#pragma once

#include <cstdint>

namespace rb {

std::int64_t iteration_caps();  // since the thread began
void count_iteration_cap();

}  // namespace rb
