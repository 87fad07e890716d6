// The step, as a table of contents. Each stage has a file of its own.
#include "world/step.hpp"

#include <algorithm>
#include <chrono>

#include "world/correct.hpp"
#include "world/detect.hpp"
#include "world/retry.hpp"

namespace rb {

namespace {

// Adds the seconds since it was made, or since it was last read, to whatever it is told to.
class StopWatch {
 public:
  void lap(double& sum) {
    const Clock::time_point now = Clock::now();
    sum += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }
  double total() const { return std::chrono::duration<double>(last_ - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now(), last_ = start_;
};

}  // namespace

namespace {

void make_step(World& world) {
  constexpr int most_retries = 8;
  StopWatch watch;
  double other = 0.0;  // s

  // Gravity, applied wrenches, kinematic targets.                               world/wrenches.cpp
  begin_step(world);
  std::fill(world.extra_travel.begin(), world.extra_travel.end(), 0.0);

  // Broad phase, narrow phase, feature matching (S7, S8), if something moved from outside.
  //                                                                             world/detect.cpp
  if (needs_detection(world)) {
    watch.lap(other);
    detect_contacts(world);
    watch.lap(world.stats.detect_time);
  }

  for (int retry = 0;; ++retry) {
    remember(world);

    // Who may meet whom.                                                        island/island.cpp
    build_islands(world);

    // Impacts (S11-S14), rest and friction (S16), contact times, free motion (S6).
    //                                            world/advance.cpp, world/carry.cpp,
    //                                            world/events.cpp, world/settle.cpp
    advance_islands(world);
    move_kinematics(world);
    require_finite(world);

    watch.lap(world.stats.advance_time);

    // The contact set at the end of the step.                                   world/detect.cpp
    detect_contacts(world);
    watch.lap(world.stats.detect_time);

    // A meeting nobody looked for: once more, with wider eyes.                  world/retry.cpp
    if (retry == most_retries || !missed_a_meeting(world)) break;
    take_back(world);
  }

  std::fill(world.extra_travel.begin(), world.extra_travel.end(), 0.0);

  // Overlap out, energy unchanged.                                              world/correct.cpp
  correct_positions(world);
  watch.lap(world.stats.correct_time);

  // Contact states (S9), contact wrenches, statistics.                          world/report.cpp
  finish_step(world);
  watch.lap(other);
  world.stats.step_time = watch.total();
}

// Below, waking another thread costs more than it gains.
bool worth_sharing(const World& world) {
  constexpr std::size_t contacts = 64, pairs = 128;
  return world.settings.threads > 1 &&
         (world.contacts.size() >= contacts || world.pairs.size() >= pairs);
}

}  // namespace

void step(World& world) {
  Workers* workers = worth_sharing(world) ? &workers_of(world) : nullptr;
  world.work.crew.run(workers, [&] { make_step(world); });
}

}  // namespace rb
