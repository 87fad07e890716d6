// Doubles at addresses that suit the widest registers. Grows, never shrinks.
#pragma once

#include <cstddef>
#include <memory>
#include <new>

namespace rb {

class WideArray {
 public:
  // Contents are lost when it grows.
  void resize(std::size_t n) {
    if (n > capacity_) {
      capacity_ = n + n / 4;
      data_.reset(static_cast<double*>(::operator new[](capacity_ * sizeof(double), kAlignment)));
    }
    size_ = n;
  }
  double* data() { return data_.get(); }
  const double* data() const { return data_.get(); }
  std::size_t size() const { return size_; }

 private:
  static constexpr std::align_val_t kAlignment{64};
  struct Free {
    void operator()(double* p) const { ::operator delete[](p, kAlignment); }
  };
  std::unique_ptr<double[], Free> data_;
  std::size_t size_ = 0, capacity_ = 0;
};

}  // namespace rb
