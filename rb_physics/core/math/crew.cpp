#include "math/crew.hpp"

#include <thread>
#include <utility>

namespace rb {
namespace {

constexpr std::uint64_t kBits = 20;
constexpr std::uint64_t kCount = (std::uint64_t{1} << kBits) - 1;

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

void Crew::open(int count) {
  threads_ = count;
  helped_ = true;
  open_.store(true, std::memory_order_release);
}

void Crew::close() {
  helped_ = false;
  open_.store(false, std::memory_order_release);
}

bool Crew::take(Part& part, int worker) {
  std::int32_t did = 0;
  std::uint64_t ticket = part.ticket.load(std::memory_order_acquire);
  for (;;) {
    const std::uint64_t next = ticket & kCount;
    if (next >= ((ticket >> kBits) & kCount)) break;
    // Who got a piece keeps the phase from ending.
    if (!part.ticket.compare_exchange_weak(ticket, ticket + 1, std::memory_order_acq_rel)) continue;
    const auto k = static_cast<std::int32_t>(next);
    try {
      call_(piece_, worker, k);
    } catch (...) {
      const std::lock_guard lock(error_mutex_);
      if (!error_ || k < error_at_) {
        error_ = std::current_exception();
        error_at_ = k;
      }
    }
    ++did;
    ticket = part.ticket.load(std::memory_order_acquire);
  }
  if (did > 0) done_.fetch_add(did, std::memory_order_acq_rel);
  return did > 0;
}

bool Crew::work(int worker) {
  bool any = false;
  for (int t = 0; t < threads_; ++t) any |= take(parts_[(worker + t) % threads_], worker);
  return any;
}

void Crew::share_all(std::int32_t n, const void* piece, Call call) {
  piece_ = piece;
  call_ = call;
  done_.store(0, std::memory_order_relaxed);
  ++phase_;
  const auto at = [&](int t) {
    return static_cast<std::uint64_t>(n) * static_cast<std::uint64_t>(t) /
           static_cast<std::uint64_t>(threads_);
  };
  for (int t = threads_ - 1; t >= 0; --t) {
    parts_[t].ticket.store((phase_ << (2 * kBits)) | (at(t + 1) << kBits) | at(t),
                           std::memory_order_release);
  }
  work(0);
  Patience patience;
  while (done_.load(std::memory_order_acquire) != n) patience.wait();
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void Crew::help(int worker) {
  Patience patience;
  while (open_.load(std::memory_order_acquire)) {
    if (work(worker)) {
      patience = {};
    } else {
      patience.wait();
    }
  }
}

}  // namespace rb
