// The inner loops of large islands, eight contacts at a time, in double precision. Compiled once
// per instruction set (wide_kernel_*.cpp); the machine's widest is chosen at run time. Every level
// does the same IEEE operations in the same order on the same lanes, nothing fused: same bits.
//
// Plain arrays only, and no template of the standard library: code compiled for a wider machine
// must not be linked into anything else.
//
// Layout. Contacts of one pair of bodies with one frame are a manifold. Eight manifolds that share
// no dynamic body are a group; lane l of every number belongs to manifold l. A group has as many
// slots as its largest manifold has points; lanes and slots left over hold zeros and do nothing.
#pragma once

#include <cstdint>

namespace rb::wide {

inline constexpr int kLanes = 8;

// Rows of eight doubles per manifold: 1/m of A and B; J^-1 of A and B (xx xy xz yy yz zz); frame
// (n, t1, t2).
enum ManifoldRow { kMassA, kMassB, kInertiaA, kInertiaB = 8, kFrame = 14, kManifoldRows = 23 };

// Per slot. `prepare` fills what stands after kFriction. With w = (W_n1, W_n2):
enum SlotRow {
  kArmA,
  kArmB = 3,
  kBias = 6,
  kFriction = 9,
  kMass = 10,      // W_nn; before `prepare`: 1 if the slot holds a contact, else 0
  kInverse = 11,   // 1 / W_nn
  kCoupling = 12,  // w / W_nn
  kPlane = 14,     // W~ = W_tt - w w^T / W_nn (11 12 22)
  kPlaneInverse = 17,
  kSlipRatio =
      20,  // slip over tangential impulse of the last sweep, 1/kg: where the next one starts
  kSlotRows = 21
};

struct Group {
  std::int32_t a[kLanes], b[kLanes];  // rows of `velocity`; `nobody` where there is none
  std::int32_t slots;
  std::int32_t manifold;  // first row of eight of this group in `manifolds`
  std::int32_t slot;      // first slot of this group in `points` and `impulse`
};

struct View {
  const Group* groups;
  std::int32_t nobody;      // a row of zeros, never written
  const double* manifolds;  // kManifoldRows x 8 per group
  double* points;           // kSlotRows x 8 per slot
  double* impulse;          // 3 x 8 per slot, N s, contact frame
  double* velocity;         // 8 per body: linear m/s, angular rad/s, 0, 0
  const double* velocity_free;
};

// What `measure` finds over a range of groups.
struct Measure {
  double worst;    // m/s, natural map, not yet relative
  double typical;  // m/s; see residual.hpp
  double operand;  // m/s, greatest speed the slips are made of
};

struct Kernel {
  const char* level;
  void (*prepare)(const View&, std::int32_t begin, std::int32_t end);
  // velocity += M^-1 J^T impulse
  void (*apply)(const View&, std::int32_t begin, std::int32_t end);
  // One Gauss-Seidel sweep over groups begin ... end - 1.
  void (*sweep)(const View&, std::int32_t begin, std::int32_t end);
  void (*sweep_frictionless)(const View&, std::int32_t begin, std::int32_t end);
  // `typical` as far as it does not depend on the impulses; noise as in residual.cpp.
  void (*measure_free)(const View&, std::int32_t begin, std::int32_t end, double noise, Measure*);
  void (*measure)(const View&, std::int32_t begin, std::int32_t end, Measure*);
  // Of arrays, elements begin ... end - 1, whole eights: |x - y|^2; and
  //   direction := beta direction + (x - last),  x := x + beta old direction,  last := x
  double (*difference_sq)(const double* x, const double* y, std::int64_t begin, std::int64_t end);
  void (*extrapolate)(double* x, double* last, double* direction, double beta, std::int64_t begin,
                      std::int64_t end);
};

const Kernel& kernel_base();
#if defined(__x86_64__)
const Kernel& kernel_avx2();
const Kernel& kernel_avx512();
#endif

}  // namespace rb::wide
