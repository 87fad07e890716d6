#include "math/workers.hpp"

#include <pthread.h>

#include <algorithm>
#include <new>

namespace rb {
namespace {

// Threads do not survive a fork: the pools of the parent are orphans in the child.
struct Registry {
  std::mutex mutex;
  std::vector<const void*> living, orphans;

  static Registry& get() {
    static Registry& registry = made();
    return registry;
  }

  void enter(const void* pool) {
    const std::lock_guard lock(mutex);
    living.push_back(pool);
  }

  // Whether the pool was an orphan; it is none from now on.
  bool leave(const void* pool) {
    const std::lock_guard lock(mutex);
    std::erase(living, pool);
    return std::erase(orphans, pool) > 0;
  }

 private:
  static Registry& made() {
    static Registry* registry = new Registry;  // outlives every pool
    pthread_atfork([] { get().mutex.lock(); }, [] { get().mutex.unlock(); },
                   [] {
                     Registry& r = get();
                     r.orphans.insert(r.orphans.end(), r.living.begin(), r.living.end());
                     r.living.clear();
                     r.mutex.unlock();
                   });
    return *registry;
  }
};

}  // namespace

Workers::Workers(int count) {
  Registry::get().enter(this);
  for (int k = 1; k < count; ++k) helpers_.emplace_back([this, k] { help(k); });
}

Workers::~Workers() {
  run_all(0, nullptr, nullptr);  // an orphan lets its dead helpers go
  Registry::get().leave(this);
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
  if (Registry::get().leave(this)) {
    // In a forked child: what the dead helpers left behind may be locked or waited for, and cannot
    // be destroyed. Begin anew, without them.
    new (&mutex_) std::mutex;
    new (&wake_) std::condition_variable;
    new (&done_) std::condition_variable;
    new (&helpers_) std::vector<std::thread>;
    open_ = false;
    inside_ = 0;
  }
  Registry::get().enter(this);
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
