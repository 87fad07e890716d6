// Which instruction set the wide kernels run with: the widest the machine has, unless the
// environment variable RB_PHYSICS_SIMD names another (base, avx2, avx512). Bits do not depend on
// it.
#pragma once

#include <string>
#include <vector>

#include "solver/wide_kernel.hpp"

namespace rb::wide {

struct Level {
  std::string name;
  bool available;  // on this machine
};

std::vector<Level> levels();  // all that were built, narrowest first

const Kernel& chosen_kernel();
// From now on, in this process. Throws std::invalid_argument if there is none of that name here.
void choose_level(const std::string& name);

}  // namespace rb::wide
