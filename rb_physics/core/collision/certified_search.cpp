#include "collision/certified_search.hpp"

#include <algorithm>
#include <cmath>

#include "collision/iteration_caps.hpp"

namespace rb {
namespace {

constexpr double most_work = 25.0;  // microseconds, about, per query that is allowed

// Root of the signed distance in [t0, t1], where it changes sign: bisection made fast by the
// Illinois rule (Dowell & Jarratt 1971).
double bracketed_root(const MovingPair& pair, double t0, double g0, double t1, double g1,
                      int& count) {
  for (int side = 0, i = 0; i < 100; ++i) {
    double t = (t0 * g1 - t1 * g0) / (g1 - g0);
    if (!(t > t0 && t < t1)) t = 0.5 * (t0 + t1);
    if (!(t > t0 && t < t1)) break;
    const double g = pair.gap(t);
    ++count;
    if (std::abs(g) <= pair.rounding(t)) return t;
    if (g > 0.0) {
      t0 = t, g0 = g;
      if (side == 1) g1 *= 0.5;
      side = 1;
    } else {
      t1 = t, g1 = g;
      if (side == -1) g0 *= 0.5;
      side = -1;
    }
  }
  return t0;
}

// One certified step of a pair from t on, along the axis n with the gap f0 > 0 there.
struct CertifiedStep {
  double length;  // s, nothing can touch within
  bool to_root;   // it ends where the lower bound meets zero
};

CertifiedStep find_step(const MovingPair& pair, const Vec3& n, double f0, double t, double trial) {
  const double left = pair.horizon() - t;
  const double slow = pair.time_to_cover(f0, t);  // nothing moves faster than this
  if (slow >= left) return {left, false};
  const double curvature = pair.curvature(n);
  double h = std::min(left, std::max(slow, std::min(trial, pair.useful_chord())));
  for (;;) {
    const double step = std::max(slow, certified_step(f0, pair.gap_along(n, t + h), h, curvature));
    if (step >= h) return {h, false};
    // A shorter trial makes a better chord; worth it until the step takes most of it.
    if (step >= 0.25 * h || h <= slow) return {step, true};
    h = std::max({2.0 * step, 0.125 * h, slow});
  }
}

}  // namespace

void CertifiedSearch::run(double until) {
  if (!begun_) {
    begun_ = true;
    trial_ = pair_.horizon();
    t_ = std::max(t_, pair_.apart_until(t_));
    if (t_ < pair_.horizon()) {
      find_ball();
      if (t_ == start_ && query(t_) <= touching() && !part()) {
        over_ = true;
        return;
      }
    }
  }
  while (!over_ && t_ <= until) {
    if (t_ >= pair_.t_max()) {
      over_ = true;
    } else if (t_ >= pair_.horizon() || spent()) {
      result_.converged = false;
      count_iteration_cap();
      end_at(t_);
    } else {
      const double before = t_;
      advance();
      // Steps below the resolution of time: the gap can't be told from zero.
      if (!over_ && !(t_ > before) && !spent()) end_at(t_);
    }
  }
}

bool CertifiedSearch::spent() const {
  return result_.iterations >= most_queries_ || work_ >= most_work * most_queries_;
}

double CertifiedSearch::touching() const {
  return std::max(1e-12 * pair_.size(), 8.0 * pair_.rounding(t_));
}

double CertifiedSearch::query(double t) {
  ++result_.iterations;
  work_ += pair_.effort(t);
  nearest_ = pair_.distance_at(t);
  return nearest_.distance;
}

void CertifiedSearch::find_ball() {
  const auto ball = pair_.ball();
  if (!ball) return;
  ball_shape_ = Sphere{ball->radius};
  ball_motion_.emplace(pair_.motion(ball->of_a));
  if (ball->of_a) {
    ball_.emplace(ball_shape_, *ball_motion_, pair_.shape(false), pair_.motion(false),
                  pair_.t_max());
  } else {
    ball_.emplace(pair_.shape(true), pair_.motion(true), ball_shape_, *ball_motion_, pair_.t_max());
  }
}

// While a ball that holds the fast turning shape is clear of the other shape, the turning need not
// be followed. True when that led on.
bool CertifiedSearch::skip_by_ball() {
  if (!ball_ || t_ < next_ball_look_) return false;
  constexpr double clear = 1e-2, later = 0.1;  // of the ball's radius
  const double radius = std::get<Sphere>(ball_shape_).radius;
  ++result_.iterations;
  work_ += ball_->effort(t_);
  const DistanceResult nearest = ball_->distance_at(t_);
  const double gap =
      std::min(nearest.distance, ball_->gap_along(nearest.normal, t_)) - ball_->rounding(t_);
  if (!(gap > clear * radius)) {
    next_ball_look_ = t_ + ball_->time_to_cover(std::max(later * radius, -gap), t_);
    return false;
  }
  const CertifiedStep step = find_step(*ball_, nearest.normal, gap, t_, ball_trial_);
  ball_trial_ = 4.0 * step.length;
  t_ = step.length >= ball_->horizon() - t_ ? ball_->horizon() : t_ + step.length;
  return true;
}

// The shapes touch or overlap at the start. True when they have parted at the new t_; else the
// search is over: an impact at the start when they sink in, nothing when they rest.
bool CertifiedSearch::part() {
  const double begin = nearest_.distance;
  // Deeper or shallower by this much is motion, not noise.
  const double noise = std::max(touching(), 1e-10 * std::abs(begin));
  const double left = pair_.horizon() - start_;
  for (double wait = left * 0x1p-40;; wait *= 2.0) {
    wait = std::min(wait, left);
    const double now = query(start_ + wait);
    if (now > touching()) {
      t_ = start_ + wait;
      return true;
    }
    if (now < begin - noise && now < -touching()) {
      result_.time = start_;
      return false;
    }
    if (wait >= left) return false;
  }
}

// One certified step from t_.
void CertifiedSearch::advance() {
  const double before = t_;
  t_ = pair_.apart_until(t_);
  if (t_ >= pair_.horizon()) return;
  if (skip_by_ball() && t_ > before) return;
  const double gap = query(t_);
  // A step to a predicted root that no longer shrinks the gap: what is left is noise of the
  // distance.
  const double rounding = pair_.rounding(t_);
  const bool stalled = approaching_ && gap > 0.5 * last_gap_ && gap <= 1e-8 * pair_.size();
  if (gap <= rounding || (stalled && gap <= 32.0 * rounding)) {
    end_at(t_);
    return;
  }
  if (stalled) {
    approaching_ = false;
    close_in(gap);
    return;
  }
  last_gap_ = gap;
  approaching_ = false;
  const Vec3 n = nearest_.normal;
  const double f0 = pair_.gap_along(n, t_);
  // Almost touching, a normal made of two nearest points is noise: work on the distance itself.
  if (!(f0 >= 0.5 * gap)) {
    close_in(gap);
    return;
  }
  const CertifiedStep step = find_step(pair_, n, f0, t_, trial_);
  double taken = step.length;
  if (step.to_root) {
    taken = std::max(taken, followed_step(std::min(gap, f0), n, taken));
    approaching_ = true;
  }
  trial_ = 4.0 * step.length;
  t_ = taken >= pair_.horizon() - t_ ? pair_.horizon() : t_ + taken;
}

// Edges that turn against each other lose along a fixed axis what their normal, turning with
// them, keeps. The same step for an axis that turns from n to the normal a little later; 0 where
// `fixed`, the step along the fixed axis, is not short of what curvature allows.
double CertifiedSearch::followed_step(double gap, const Vec3& n, double fixed) {
  if (pair_.has_plane()) return 0.0;
  const double expected = pair_.curvature(pair_.angular_speed(), t_, 0.0);
  const double h = std::min(pair_.horizon() - t_, std::sqrt(8.0 * gap / expected));
  if (!(fixed < 0.2 * h)) return 0.0;
  query(t_ + h);
  const double chord = (nearest_.normal - n).norm();
  if (!(chord < 0.7)) return 0.0;
  constexpr double arc = 1.03;  // an arc is at most so much longer than such a chord
  const double curvature = pair_.curvature(arc * chord / h, t_, h);
  return certified_step(gap, pair_.gap_along(nearest_.normal, t_ + h), h, curvature);
}

// From a gap too small for normals: find the sign change of the distance, or the way out of the
// gap.
void CertifiedSearch::close_in(double gap) {
  const double near = std::max(2.0 * gap, 1e-7 * pair_.size());
  const double longest = std::sqrt(8.0 * near / std::max(pair_.max_curvature(), 1e-300));
  double before = t_, before_gap = gap;
  double h = pair_.time_to_cover(gap, t_);
  while (before < pair_.horizon() && !spent()) {
    const double t = std::min(before + h, pair_.horizon());
    if (!(t > before)) {  // time itself can't tell the gap from zero
      end_at(t);
      return;
    }
    const double now = query(t);
    if (std::abs(now) <= pair_.rounding(t)) {
      end_at(t);
      return;
    }
    if (now < 0.0) {
      end_at(bracketed_root(pair_, before, before_gap, t, now, result_.iterations));
      return;
    }
    t_ = before = t;
    before_gap = now;
    if (now > near) return;
    h = std::min(2.0 * h, longest);
  }
}

}  // namespace rb
