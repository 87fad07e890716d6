// A pool of threads that share out independent pieces of work. Which thread does which piece is
// left to chance: pieces must not depend on each other, then results don't depend on the count of
// threads.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace rb {

class Workers {
 public:
  explicit Workers(int count);  // threads, the caller's included; >= 1
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  int count() const { return static_cast<int>(helpers_.size()) + 1; }

  // Calls piece(worker, k) once for every k in [0, n), worker in [0, count()); returns when all are
  // done. Of several exceptions the one of the lowest k is thrown on. Waiting helpers sleep.
  template <class Piece>
  void run(std::size_t n, const Piece& piece) {
    run_all(n, &piece, [](const void* p, int worker, std::size_t k) {
      (*static_cast<const Piece*>(p))(worker, k);
    });
  }

 private:
  using Call = void (*)(const void* piece, int worker, std::size_t k);
  void run_all(std::size_t n, const void* piece, Call call);
  void help(int worker);
  void work(int worker);

  std::mutex mutex_;
  std::condition_variable wake_, done_;
  bool open_ = false;  // a job helpers may join
  bool quit_ = false;
  int inside_ = 0;        // helpers in the present job
  std::size_t job_ = 0;   // number of the present job
  std::size_t size_ = 0;  // its pieces
  std::atomic<std::size_t> next_{0};
  const void* piece_ = nullptr;
  Call call_ = nullptr;
  std::exception_ptr error_;
  std::size_t error_at_ = 0;
  std::vector<std::thread> helpers_;
};

}  // namespace rb
