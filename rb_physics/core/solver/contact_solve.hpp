// One solve of one island: what its stages share. Each file has the stages of one kind.
#pragma once

#include <algorithm>
#include <cstddef>

#include "solver/contact_solver.hpp"

namespace rb {

struct ContactSolve {
  static constexpr std::size_t kLarge = 64;  // contacts: more of them end where rounding shows
  static constexpr int kFirstSweeps = 5;     // find most of the active set
  static constexpr double kSoftness = 1e-8;
  static constexpr double kRounding = 1e-15;  // no use to insist below it
  static constexpr double kFollow = 3e-2;     // one below it has mostly the same faces
  static constexpr double kTouchUp = 1e-9;    // a start below it is mostly one Newton step away

  const ContactProblem& problem;
  const SolverSettings& settings;
  ContactSolution& io;
  SolverWorkspace& ws;
  SolveReport report;
  double work = 0.0;   // sweeps over one contact
  double floor = 0.0;  // what rounding leaves of the residual
  double target = 0.0;
  double typical = 0.0;           // m/s, what the residual is relative to
  ContactResidual measured = {};  // by measure(), the last time
  bool swept = false;             // what sweeps need is there
  bool has_friction = true;       // some contact resists slipping or turning
  bool may_release = true;        // some contact has two coefficients of friction

  bool out_of_work() {
    if (settings.max_work > 0 && work >= static_cast<double>(settings.max_work)) {
      report.work_exhausted = true;
    }
    return report.work_exhausted;
  }

  // What the first Newton attempt goes on to: where light contacts are right beside heavy ones.
  double goal() const {
    constexpr double rounding = 5e-16;
    constexpr double share = 0.1;  // of what a warm start may leave
    const double light = share * settings.warm_speed / typical;
    return std::max({floor, rounding, std::min(settings.newton_goal, light)});
  }

  static double face_threshold(const ContactResidual& r) {
    return std::max(1e-11, 30.0 * r.natural_map) * r.typical_velocity;
  }

  // Least impulses seem not to exist, and nearly nothing has changed.
  bool gave_up() const { return io.vain_searches >= most_vain_searches; }

  bool large() const { return problem.contacts.size() > kLarge; }

  // solver/contact_solver.cpp
  ContactResidual measure();
  void start();
  // Slips against a static coefficient: the kinetic one from now on. True if any changed.
  bool release_sliding(double typical_velocity);
  bool accept_warm_start();
  using Power = SolverWorkspace::Power;
  Power power();
  double harmless_share();
  bool shrink();
  void lose_energy();
  void run();

  // solver/swept_solve.cpp
  // Sweeps until the target, `count`, or the end of work.
  void sweep(int count);
  // The same, contact by contact, for those with rolling or spinning friction.
  void iterate_moments();
  // Wide sweeps, accelerated by the nonsmooth nonlinear conjugate gradient method (Silcowitz, Niebe
  // & Erleben 2010), which takes the change of one sweep for the gradient.
  // `patience`: so many that gain less than half of the residual are the last ones; 0: never.
  WideResidual wide_sweeps(int most, int patience = 0);
  // Large islands, where the forces take no part in a factorisation.
  void iterate();

  // solver/direct_solve.cpp
  void newton(int attempt, double softness = kSoftness, int most_outer = 30);
  // Of many contacts, and every body among many others: Newton is dear there and often circles,
  // and the next step will have another jam.
  bool jam() const;
  // A start for Newton where sweeps leave too much open. Kept if it is nearer.
  void interior();
  // Contacts without friction: true if their impulses are found.
  bool pivot_normals();
  void solve_direct();
  // Few contacts: from where it is, then (but for a step) from the answer without friction.
  void follow_friction(int most_steps);
  // Where friction is strong, Newton may circle around a start that is near: another one, from what
  // each contact asks for by itself, so that neither the order of the contacts nor the axes matter.
  void start_elsewhere(int number);

  // solver/least_impulses.cpp
  // Two linear solves that take out what rounding has left or made. False: nothing changed.
  bool refine();
  // Most of the solves of a stack at rest: the old forces but for their drift.
  bool touch_up();
  // Contacts that stick on, though their geometry and their load have changed: impulses of last
  // step's certificate, and what they leave of the slips. Mostly one factorisation.
  bool follow_certificate();
  // Where contacts slide: of all answers the one that their order has no part in.
  ContactResidual even_slides(ContactResidual r);
  void least_impulses(const ContactResidual& r);
  void least_impulses_of_jam(const ContactResidual& r);
  // What a full solve leaves sways a tower as a whole: small slips, large forces later on.
  void polish();
};

}  // namespace rb
