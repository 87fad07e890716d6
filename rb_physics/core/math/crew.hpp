// Threads that go through the many short phases of a step together, with hardly any time between
// two of them: one leads and hands out pieces, the others help with whatever is handed out and wait
// on the processor for more. Helpers need not be there: who comes late joins the present phase. As
// with Workers, pieces of a phase must not depend on each other; then results don't depend on the
// count of threads.
//
// Each thread begins with a part of the pieces that is its own, the same in every phase, and then
// helps with those that are left: what a thread wrote in one phase it mostly finds in its own cache
// in the next, if piece k stands for the same bodies in both.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <mutex>

#include "math/workers.hpp"

namespace rb {

class Crew {
 public:
  Crew() = default;
  Crew(Crew&&) noexcept {}  // of a crew at rest there is nothing to move

  // Calls lead() once, on this thread; the others of the pool help. workers may be null: no
  // helpers. Within lead() another run() just calls.
  template <class Lead>
  void run(Workers* workers, const Lead& lead) {
    if (helped_ || workers == nullptr || workers->count() == 1) return lead();
    open(std::min(workers->count(), kMost));
    bool led = false;  // the others help until it is: the first piece this thread gets is the lead
    workers->run(static_cast<std::size_t>(workers->count()), [&](int worker, std::size_t) {
      if (worker != 0) return help(worker);
      if (led) return;
      led = true;
      const Closing closing{*this};
      lead();
    });
  }

  int threads() const { return helped_ ? threads_ : 1; }
  bool helped() const { return helped_; }

  // From within lead(): piece(worker, k) for every k in [0, n), n < 2^20, worker in
  // [0, workers->count()); returns when all are done. Of several exceptions the one of the lowest k
  // is thrown on.
  template <class Piece>
  void share(std::int32_t n, const Piece& piece) {
    if (!helped_ || n <= 1) {
      for (std::int32_t k = 0; k < n; ++k) piece(0, k);
      return;
    }
    share_all(n, &piece, [](const void* p, int worker, std::int32_t k) {
      (*static_cast<const Piece*>(p))(worker, k);
    });
  }

  // The same over blocks: piece(begin, end) of [0, n), about two for each thread but none smaller
  // than `least`. Where blocks end depends on the count of threads, so what is done with an element
  // must not depend on its block.
  template <class Piece>
  void share_range(std::size_t n, std::size_t least, const Piece& piece) {
    const auto most = static_cast<std::size_t>(2 * threads());
    const std::size_t pieces = most == 2 ? 1 : std::clamp<std::size_t>(n / least, 1, most);
    if (n == 0) return;
    share(static_cast<std::int32_t>(pieces), [&](int, std::int32_t k) {
      const auto at = [&](std::int32_t i) { return n * static_cast<std::size_t>(i) / pieces; };
      piece(at(k), at(k + 1));
    });
  }

 private:
  using Call = void (*)(const void* piece, int worker, std::int32_t k);
  static constexpr int kMost = 64;  // threads; more of a pool have nothing to do
  struct Closing {
    Crew& crew;
    ~Closing() { crew.close(); }
  };
  // A thread's own part of a phase: phase (24 bits), its end (20), the next piece (20).
  struct alignas(64) Part {
    std::atomic<std::uint64_t> ticket{0};
  };

  void open(int count);
  void close();
  void share_all(std::int32_t n, const void* piece, Call call);
  void help(int worker);
  bool work(int worker);  // true if there was any
  bool take(Part& part, int worker);

  bool helped_ = false;  // the leader's
  int threads_ = 1;      // of the last run
  std::atomic<bool> open_{false};
  std::uint64_t phase_ = 0;
  std::array<Part, kMost> parts_;
  alignas(64) std::atomic<std::int32_t> done_{0};  // pieces of the phase
  const void* piece_ = nullptr;
  Call call_ = nullptr;
  std::mutex error_mutex_;
  std::exception_ptr error_;
  std::int32_t error_at_ = 0;
};

}  // namespace rb
