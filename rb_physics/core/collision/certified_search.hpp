// The contact time of a moving pair by certified steps: no impact is stepped over.
#pragma once

#include <limits>
#include <optional>

#include "collision/moving_pair.hpp"
#include "collision/sweep.hpp"

namespace rb {

// A search that can be left and taken up again, so that many can go on side by side. Not to be
// moved.
class CertifiedSearch {
 public:
  // Looks for an impact at `start` (s) or later, to the pair's t_max. The pair must outlive it.
  CertifiedSearch(const MovingPair& pair, double start, int most_queries)
      : pair_(pair), most_queries_(most_queries), start_(start), t_(start) {}
  CertifiedSearch(const CertifiedSearch&) = delete;
  CertifiedSearch& operator=(const CertifiedSearch&) = delete;

  // Goes on until the answer is known, or nothing met up to a time later than `until`.
  void run(double until);

  bool is_over() const { return over_; }
  double reached() const { return t_; }  // s, nothing met before
  // Where it is over: the impact, if there is one. `converged` is false where work ran out.
  const ImpactSearch& result() const { return result_; }

 private:
  double touching() const;
  double query(double t);
  bool part();
  void advance();
  bool skip_by_ball();
  double followed_step(double gap, const Vec3& n, double fixed);
  void close_in(double gap);
  void find_ball();
  void end_at(double t) {
    result_.time = t;
    over_ = true;
  }
  bool spent() const;

  const MovingPair& pair_;
  int most_queries_;
  ImpactSearch result_;
  DistanceResult nearest_;
  double start_, t_;
  double trial_ = std::numeric_limits<double>::infinity();  // s, length of the next chord to try
  double last_gap_ = 0.0;
  double work_ = 0.0;  // microseconds, about
  bool begun_ = false, over_ = false;
  bool approaching_ = false;  // the last step went to the root of the lower bound

  // The pair with a ball in place of the shape that turns fast.
  std::optional<CenterSweep> ball_motion_;
  Shape ball_shape_;
  std::optional<MovingPair> ball_;
  double ball_trial_ = std::numeric_limits<double>::infinity();
  double next_ball_look_ = 0.0;  // s
};

}  // namespace rb
