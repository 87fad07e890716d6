#include "math/crew.hpp"

#include <thread>

namespace rb {
namespace {

constexpr std::uint64_t kCount = (std::uint64_t{1} << 20) - 1;

// Waits a moment; longer ones are given to other threads of the machine.
class Patience {
 public:
  void wait() {
    constexpr int spins = 4000;
    if (++waits_ > spins) {
      std::this_thread::yield();
      return;
    }
#if defined(__x86_64__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    asm volatile("yield");
#endif
  }

 private:
  int waits_ = 0;
};

}  // namespace

bool Crew::take_one() {
  std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
  for (;;) {
    const std::uint64_t next = ticket & kCount;
    if (next >= ((ticket >> 20) & kCount)) return false;
    if (ticket_.compare_exchange_weak(ticket, ticket + 1, std::memory_order_acq_rel)) {
      call_(piece_, static_cast<std::int32_t>(next));
      done_.fetch_add(1, std::memory_order_release);
      return true;
    }
  }
}

void Crew::share_all(std::int32_t n, const void* piece, Call call) {
  piece_ = piece;
  call_ = call;
  done_.store(0, std::memory_order_relaxed);
  const std::uint64_t phase = (ticket_.load(std::memory_order_relaxed) >> 40) + 1;
  ticket_.store((phase << 40) | (static_cast<std::uint64_t>(n) << 20), std::memory_order_release);
  while (take_one()) {
  }
  Patience patience;
  while (done_.load(std::memory_order_acquire) != n) patience.wait();
}

void Crew::help() {
  Patience patience;
  while (open_.load(std::memory_order_acquire)) {
    if (take_one()) {
      patience = {};
    } else {
      patience.wait();
    }
  }
}

}  // namespace rb
