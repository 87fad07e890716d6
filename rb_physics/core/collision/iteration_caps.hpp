// Counts queries whose iterations ran out (they still answer, less exactly).
#pragma once

#include <cstdint>

namespace rb {

std::int64_t iteration_caps();  // of the calling thread since it began
void count_iteration_cap();

// Adds what the calling thread met during its life to `total`.
class IterationCapCounter {
 public:
  explicit IterationCapCounter(int& total) : total_(total), start_(iteration_caps()) {}
  ~IterationCapCounter() { total_ += static_cast<int>(iteration_caps() - start_); }
  IterationCapCounter(const IterationCapCounter&) = delete;
  IterationCapCounter& operator=(const IterationCapCounter&) = delete;

 private:
  int& total_;
  std::int64_t start_;
};

}  // namespace rb
