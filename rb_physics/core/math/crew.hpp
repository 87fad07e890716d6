// Threads that go through many short phases together, with hardly any time between two of them: one
// leads and hands out pieces, the others help with whatever is handed out and wait on the processor
// for more. Helpers need not be there: who comes late joins the present phase. As with Workers,
// pieces of a phase must not depend on each other; then results don't depend on the count of
// threads.
#pragma once

#include <atomic>
#include <cstdint>

#include "math/workers.hpp"

namespace rb {

class Crew {
 public:
  Crew() = default;
  Crew(Crew&&) noexcept {}  // of a crew at rest there is nothing to move

  // Calls lead() once, on one thread; the others of the pool help. workers may be null: no helpers.
  // Within lead() another run() just calls.
  template <class Lead>
  void run(Workers* workers, const Lead& lead) {
    if (helped_ || workers == nullptr || workers->count() == 1) return lead();
    open_.store(true, std::memory_order_release);
    helped_ = true;
    workers->run(static_cast<std::size_t>(workers->count()), [&](int, std::size_t k) {
      if (k != 0) return help();
      const Closing closing{*this};
      lead();
    });
  }

  // From within lead(): piece(k) for every k in [0, n), n < 2^20; returns when all are done.
  template <class Piece>
  void share(std::int32_t n, const Piece& piece) {
    if (!helped_ || n <= 1) {
      for (std::int32_t k = 0; k < n; ++k) piece(k);
      return;
    }
    share_all(n, &piece, [](const void* p, std::int32_t k) { (*static_cast<const Piece*>(p))(k); });
  }

 private:
  using Call = void (*)(const void* piece, std::int32_t k);
  struct Closing {
    Crew& crew;
    ~Closing() {
      crew.helped_ = false;
      crew.open_.store(false, std::memory_order_release);
    }
  };

  void share_all(std::int32_t n, const void* piece, Call call);
  void help();
  bool take_one();

  std::atomic<bool> open_{false};
  bool helped_ = false;                   // the leader's
  std::atomic<std::uint64_t> ticket_{0};  // phase (24 bits), its pieces (20), the next one (20)
  std::atomic<std::int32_t> done_{0};     // pieces of the phase
  const void* piece_ = nullptr;
  Call call_ = nullptr;
};

}  // namespace rb
