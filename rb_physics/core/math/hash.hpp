// A 64-bit running hash of plain data. Bits in, bits out: -0.0 and 0.0 differ, as replay demands.
#pragma once

#include <cstdint>
#include <cstring>

namespace rb {

class Hash {
 public:
  void add(std::uint64_t word) {
    // One round of multiply and xor-shift a word (splitmix64's finaliser on a running state).
    state_ = (state_ ^ word) * 0xbf58476d1ce4e5b9ULL;
    state_ ^= state_ >> 29;
    state_ = state_ * 0x94d049bb133111ebULL + 0x9e3779b97f4a7c15ULL;
    state_ ^= state_ >> 32;
  }
  void add(double value) {
    std::uint64_t word;
    std::memcpy(&word, &value, sizeof word);
    add(word);
  }
  template <class Vector>
  void add_all(const Vector& v) {
    for (int i = 0; i < static_cast<int>(v.size()); ++i) add(static_cast<double>(v.data()[i]));
  }
  std::uint64_t value() const { return state_; }

 private:
  std::uint64_t state_ = 0x243f6a8885a308d3ULL;
};

}  // namespace rb
