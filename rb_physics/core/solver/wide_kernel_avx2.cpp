// The kernel for x86-64 with AVX2.
#if defined(__x86_64__)
#pragma GCC target("avx2")
#include "solver/wide_kernel_body.hpp"

namespace rb::wide {

const Kernel& kernel_avx2() {
  static constexpr Kernel kernel = make_kernel("avx2");
  return kernel;
}

}  // namespace rb::wide
#endif
