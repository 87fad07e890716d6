#include "collision/iteration_caps.hpp"

namespace rb {

namespace {
thread_local std::int64_t caps = 0;
}

std::int64_t iteration_caps() { return caps; }
void count_iteration_cap() { ++caps; }

}  // namespace rb
