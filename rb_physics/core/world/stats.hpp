// What the last step did, for people who want to know whether to trust it.
#pragma once

#include <cstdint>

namespace rb {

struct Stats {
  double residual = 0.0;   // largest relative natural-map residual of the step's contact solves
  int iterations = 0;      // solver iterations, all islands
  int contacts = 0;        // contact points that touched or carried an impulse
  int islands = 0;         // groups of bodies connected by contacts
  int pairs = 0;           // broad-phase pairs
  int events = 0;          // contact times and stick events found inside the step
  int impacts = 0;         // impact-law solves
  int corrections = 0;     // position corrections (they change no velocity)
  int capped = 0;          // islands that met max_work or max_events: their answer is as reported
  int waits = 0;           // of these, islands that wait out the step's rest at a contact
  int queries_capped = 0;  // geometric queries whose iterations ran out: they answer less exactly
  int retries = 0;         // times the step was taken back for a meeting nobody looked for
  int asleep = 0;          // dynamic bodies that sleep
  double max_penetration = 0.0;  // m, at the end of the step
  double energy_error = 0.0;     // kinetic energy contact solves gained, relative; 0 when none did

  // Wall-clock time of the step's stages, s: for reports, never for physics.
  double detect_time = 0.0;   // broad and narrow phase
  double advance_time = 0.0;  // islands: impacts, contact solves, contact times, motion
  double correct_time = 0.0;  // overlap out
  double step_time = 0.0;     // the whole step
};

// The worst of the steps since it was last asked for.
struct WorstOfSteps {
  double residual = 0.0;
  double max_penetration = 0.0;  // m
  int contacts = 0;
};

}  // namespace rb
