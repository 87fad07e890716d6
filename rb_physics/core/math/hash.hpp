// A 64-bit running hash of plain data. Bits in, bits out: -0.0 and 0.0 differ, as replay demands.
//
// Words go to eight lanes in turn, because one lane is a single chain of dependent multiplications
// that leaves the processor idle. Recordings hold these hashes: a change here is a new
// FORMAT_VERSION in recording/recorder.py.
#pragma once

#include <cstdint>
#include <cstring>

namespace rb {

class Hash {
 public:
  void add(std::uint64_t word) {
    std::uint64_t& lane = lanes_[count_++ & 7];
    lane = mixed(lane, word);
  }
  void add(double value) {
    std::uint64_t word;
    std::memcpy(&word, &value, sizeof word);
    add(word);
  }
  std::uint64_t value() const {
    std::uint64_t all = count_;
    for (const std::uint64_t lane : lanes_) all = mixed(all, lane);
    return all;
  }

 private:
  // One round of multiply and xor-shift a word: splitmix64's finaliser on a running state. It is
  // one-to-one in the word, so a single word that differs is never missed.
  static std::uint64_t mixed(std::uint64_t state, std::uint64_t word) {
    state = (state ^ word) * 0xbf58476d1ce4e5b9ULL;
    state ^= state >> 29;
    state = state * 0x94d049bb133111ebULL + 0x9e3779b97f4a7c15ULL;
    return state ^ (state >> 32);
  }

  // Digits of pi: lanes that differ, so that words swapped between two lanes are noticed.
  std::uint64_t lanes_[8] = {0x243f6a8885a308d3ULL, 0x13198a2e03707344ULL, 0xa4093822299f31d0ULL,
                             0x082efa98ec4e6c89ULL, 0x452821e638d01377ULL, 0xbe5466cf34e90c6cULL,
                             0xc0ac29b7c97c50ddULL, 0x3f84d5b5b5470917ULL};
  std::uint64_t count_ = 0;
};

}  // namespace rb
