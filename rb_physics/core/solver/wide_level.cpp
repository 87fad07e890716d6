#include "solver/wide_level.hpp"

#include <atomic>
#include <cstdlib>
#include <stdexcept>

namespace rb::wide {
namespace {

struct Candidate {
  const Kernel* kernel;
  bool available;
};

std::vector<Candidate> candidates() {
  std::vector<Candidate> all{{&kernel_base(), true}};
#if defined(__x86_64__)
  __builtin_cpu_init();
  all.push_back({&kernel_avx2(), __builtin_cpu_supports("avx2") != 0});
  all.push_back({&kernel_avx512(), __builtin_cpu_supports("avx512f") != 0 &&
                                       __builtin_cpu_supports("avx512dq") != 0});
#endif
  return all;
}

const Kernel& find(const std::string& name) {
  std::string known;
  for (const Candidate& c : candidates()) {
    if (name == c.kernel->level && c.available) return *c.kernel;
    if (c.available) known += (known.empty() ? "" : ", ") + std::string(c.kernel->level);
  }
  throw std::invalid_argument("no SIMD level '" + name + "' on this machine; there are: " + known);
}

const Kernel& first_choice() {
  if (const char* asked = std::getenv("RB_PHYSICS_SIMD"); asked != nullptr && *asked != '\0') {
    return find(asked);
  }
  const Kernel* widest = nullptr;
  for (const Candidate& c : candidates()) {
    if (c.available) widest = c.kernel;
  }
  return *widest;
}

std::atomic<const Kernel*> chosen{nullptr};

}  // namespace

std::vector<Level> levels() {
  std::vector<Level> out;
  for (const Candidate& c : candidates()) out.push_back({c.kernel->level, c.available});
  return out;
}

const Kernel& chosen_kernel() {
  const Kernel* kernel = chosen.load(std::memory_order_acquire);
  if (kernel == nullptr) {
    kernel = &first_choice();
    chosen.store(kernel, std::memory_order_release);
  }
  return *kernel;
}

void choose_level(const std::string& name) { chosen.store(&find(name), std::memory_order_release); }

}  // namespace rb::wide
