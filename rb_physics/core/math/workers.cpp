#include "math/workers.hpp"

namespace rb {

Workers::Workers(int count) {
  for (int k = 1; k < count; ++k) helpers_.emplace_back([this, k] { help(k); });
}

Workers::~Workers() {
  {
    const std::lock_guard lock(mutex_);
    quit_ = true;
  }
  wake_.notify_all();
  for (std::thread& helper : helpers_) helper.join();
}

void Workers::work(int worker) {
  for (;;) {
    const std::size_t k = next_.fetch_add(1, std::memory_order_relaxed);
    if (k >= size_) return;
    try {
      call_(piece_, worker, k);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!error_ || k < error_at_) {
        error_ = std::current_exception();
        error_at_ = k;
      }
    }
  }
}

void Workers::help(int worker) {
  std::size_t seen = 0;
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [&] { return quit_ || (open_ && job_ != seen); });
    if (quit_) return;
    seen = job_;
    ++inside_;
    lock.unlock();
    work(worker);
    lock.lock();
    if (--inside_ == 0) done_.notify_one();
  }
}

void Workers::run_all(std::size_t n, const void* piece, Call call) {
  {
    const std::lock_guard lock(mutex_);
    piece_ = piece;
    call_ = call;
    size_ = n;
    next_.store(0, std::memory_order_relaxed);
    error_ = nullptr;
    ++job_;
    open_ = true;
  }
  wake_.notify_all();
  work(0);
  std::unique_lock lock(mutex_);
  open_ = false;  // who has not come by now has nothing left to do
  done_.wait(lock, [&] { return inside_ == 0; });
  if (error_) std::rethrow_exception(error_);
}

}  // namespace rb
