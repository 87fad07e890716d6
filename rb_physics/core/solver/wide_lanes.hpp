// Eight doubles side by side and vectors of them, for the instruction set the including file has
// chosen: each level compiles them for itself (wide_kernel_body.hpp).
#pragma once

#if defined(__AVX2__) || defined(__SSE2__)
#include <immintrin.h>
#endif

#include "solver/wide_kernel.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace rb::wide {
namespace {

typedef double Wide __attribute__((vector_size(64)));
typedef long long Mask __attribute__((vector_size(64)));
#define RB_INLINE inline __attribute__((always_inline))

RB_INLINE Wide load(const double* p) { return *reinterpret_cast<const Wide*>(p); }
RB_INLINE void store(double* p, Wide x) { *reinterpret_cast<Wide*>(p) = x; }
RB_INLINE Wide all(double x) { return Wide{x, x, x, x, x, x, x, x}; }
RB_INLINE Wide greater(Wide x, Wide y) { return x > y ? x : y; }  // y where x is NaN

// Lanes of a, then of b, by number.
template <int... lane, class Lanes>
RB_INLINE Lanes shuffled(Lanes a, Lanes b) {
#if defined(__clang__) || __GNUC__ >= 12
  return __builtin_shufflevector(a, b, lane...);
#else
  return __builtin_shuffle(a, b, Mask{lane...});
#endif
}

RB_INLINE bool none(Mask m) {
  m |= shuffled<4, 5, 6, 7, 0, 1, 2, 3>(m, m);
  m |= shuffled<2, 3, 0, 1, 6, 7, 4, 5>(m, m);
  return (m[0] | m[1]) == 0;
}

RB_INLINE Wide square_root(Wide x) {
#if defined(__AVX512F__)
  return reinterpret_cast<Wide>(_mm512_sqrt_pd(reinterpret_cast<__m512d>(x)));
#elif defined(__AVX2__)
  union {
    Wide w;
    __m256d p[2];
  } u{x};
  for (__m256d& p : u.p) p = _mm256_sqrt_pd(p);
  return u.w;
#elif defined(__SSE2__)
  union {
    Wide w;
    __m128d p[4];
  } u{x};
  for (__m128d& p : u.p) p = _mm_sqrt_pd(p);
  return u.w;
#else
  for (int l = 0; l < kLanes; ++l) x[l] = __builtin_sqrt(x[l]);
  return x;
#endif
}

struct Vector {
  Wide x, y, z;
};
RB_INLINE Vector load_vector(const double* p) { return {load(p), load(p + 8), load(p + 16)}; }
RB_INLINE Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
RB_INLINE Vector operator-(Vector a, Vector b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
RB_INLINE Vector operator*(Wide s, Vector a) { return {s * a.x, s * a.y, s * a.z}; }
RB_INLINE Wide dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
RB_INLINE Vector cross(Vector a, Vector b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
RB_INLINE Wide norm(Vector a) { return square_root(dot(a, a)); }

// Symmetric: rows xx xy xz yy yz zz.
RB_INLINE Vector times(const double* s, Vector a) {
  const Wide xx = load(s), xy = load(s + 8), xz = load(s + 16);
  const Wide yy = load(s + 24), yz = load(s + 32), zz = load(s + 40);
  return {xx * a.x + xy * a.y + xz * a.z, xy * a.x + yy * a.y + yz * a.z,
          xz * a.x + yz * a.y + zz * a.z};
}

// 8 x 8, in place.
RB_INLINE void transpose(Wide (&r)[8]) {
  Wide s[8];
  for (int k = 0; k < 8; k += 2) {
    s[k] = shuffled<0, 8, 2, 10, 4, 12, 6, 14>(r[k], r[k + 1]);
    s[k + 1] = shuffled<1, 9, 3, 11, 5, 13, 7, 15>(r[k], r[k + 1]);
  }
  for (int k = 0; k < 8; k += 4) {
    for (int i = 0; i < 2; ++i) {
      r[k + i] = shuffled<0, 1, 8, 9, 4, 5, 12, 13>(s[k + i], s[k + i + 2]);
      r[k + i + 2] = shuffled<2, 3, 10, 11, 6, 7, 14, 15>(s[k + i], s[k + i + 2]);
    }
  }
  for (int i = 0; i < 4; ++i) {
    s[i] = shuffled<0, 1, 2, 3, 8, 9, 10, 11>(r[i], r[i + 4]);
    s[i + 4] = shuffled<4, 5, 6, 7, 12, 13, 14, 15>(r[i], r[i + 4]);
  }
  for (int i = 0; i < 8; ++i) r[i] = s[i];
}

RB_INLINE double greatest_lane(Wide x) {
  double most = x[0];
  for (int l = 1; l < kLanes; ++l) most = x[l] > most ? x[l] : most;
  return most;
}

}  // namespace
}  // namespace rb::wide
