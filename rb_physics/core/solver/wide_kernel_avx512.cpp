// The kernel for x86-64 with AVX-512 (F and DQ).
#if defined(__x86_64__)
#pragma GCC target("avx512f,avx512dq,avx2")
#include "solver/wide_kernel_body.hpp"

namespace rb::wide {

const Kernel& kernel_avx512() {
  static constexpr Kernel kernel = make_kernel("avx512");
  return kernel;
}

}  // namespace rb::wide
#endif
