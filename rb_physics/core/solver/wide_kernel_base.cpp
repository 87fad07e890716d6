// The kernel for what every machine has: SSE2 on x86-64, NEON on AArch64.

#include "solver/wide_kernel_body.hpp"

namespace rb::wide {

const Kernel& kernel_base() {
  static constexpr Kernel kernel = make_kernel("base");
  return kernel;
}

}  // namespace rb::wide
