// The kernel for what every machine has: SSE2 on x86-64, NEON on AArch64.

#include "solver/wide_kernel_body.hpp"

namespace rb::wide {

const Kernel& kernel_base() {
  static constexpr Kernel kernel{
      "base",       prepare, apply,         sweep,      sweep_frictionless,
      measure_free, measure, difference_sq, extrapolate};
  return kernel;
}

}  // namespace rb::wide
