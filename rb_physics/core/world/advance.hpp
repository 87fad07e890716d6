// One island over one step: fly, meet, strike, rest (S7, S9, S13-S16), as often as the step asks
// for.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "contact/builder.hpp"
#include "math/tolerances.hpp"
#include "world/contact_rates.hpp"
#include "world/group_balance.hpp"
#include "world/world.hpp"

namespace rb {

// Displaces a body (m, rad); its momenta stay.
void shift_body(Body& body, const Vec6& displacement);

// Corner on face: its points are those of the bodies, which move with them; but for second order.
bool is_flat(const World& world, const Contact& contact);  // world/close.cpp

// m/s: a slip slower than this sticks.
inline double stick_speed() { return tolerance::resting_speed; }

// An island on its way through a step. Bodies are moved in place; contacts live here until the step
// ends.
class IslandAdvance {
 public:
  IslandAdvance(World& world, std::span<const std::int32_t> rows, IslandWorkspace& work);

 private:
  World& world_;
  std::span<const std::int32_t> rows_;
  IslandWorkspace& work_;

 public:
  std::vector<Contact>& contacts = work_.contacts;     // ordered by pair
  std::vector<Contact>& departed = work_.departed;     // carried an impulse, gone now
  std::vector<ColliderPair>& pairs = work_.pairs;      // those that have contacts within reach
  std::vector<ColliderPair>& covered = work_.covered;  // ordered; their seams are not felt now

  // Instead of copies of its contacts the island gets the world's whole list, if it has most of
  // them and moves in one solve; what is of others stays as it is.
  bool take_contacts(std::span<const std::int32_t> edges);

  // Moves the island by h seconds.
  void run(double h);

  bool found_again = false;  // the list of contacts is no longer the one it was given
  Stats stats;

 private:
  void run_in_one_solve(double h);  // world/one_solve.cpp
  void take_at_once(double h);
  struct Materials {
    bool rebound;  // something that touches may bounce off: only then is an impact law applied
    bool moments;  // there is rolling or spinning friction
  };
  Materials look_at_materials();
  void solve_at_once(double h, const Materials& materials);
  void solve_apart(double h, const Materials& materials);
  void hold(double h);
  bool close_gaps(double h);
  void take_back_at_once(double h, bool closed);
  // Impacts at the present instant: touching contacts that approach faster than rest explains (S13,
  // S14). `left` seconds of the step are to come: false if they are to be taken in one solve, with
  // impacts that nothing rebounds from in it, as a jam of many contacts is.
  bool strike(double left);
  bool takes_one_solve(double left);
  // Forces over the next tau seconds: resting and sliding contacts (S16 in velocities). Fills
  // `total_`. far_too: contacts not yet touching count as well, with the gap they may close.
  void carry(double tau, bool far_too);
  void carry_to_end(double tau);
  double drift_speed(const Contact& c) const;
  bool slides(const Contact& c, const Vec3& u) const;
  bool closes_gap() const;
  void without_drift(double tau, double warm_speed);
  void remember_forces(double tau, const ContactSolution& solution);
  void add_forces(double tau);
  // Takes the height of rebounds that are over by the end out of the displacement. Fills `shift_`.
  void settle(double tau, bool last);
  void close_loaded(double tau);
  bool close_once(double tau);
  ContactPlace place_after(const Contact& c, double tau, double& gap) const;
  void shift_to_end_velocities(double tau);
  // What turning contacts and displacements made of energy and angular momentum over tau.
  void take_back(double tau);
  BodyGain gain_of(std::size_t k, double tau) const;
  // Books what `carry` found as impulses of the contacts.
  void book();
  // Moves every body under `total_`, from the states saved by `mark`.
  void move(double tau);
  void move_body(std::size_t k, double tau);
  void mark();
  // Earliest time in (0, tau) at which a contact that does not touch yet closes, else tau.
  double next_contact_time(double tau);  // fills `met_`
  double contact_time_of_pair(const ColliderPair& pair, double tau);
  double unhurt_until(const ColliderPair& pair, double t, double tau);
  bool may_pass(double t) const;
  void wait(double t);
  double width_between(const ColliderPair& pair) const;
  // Shortens tau (s) until nothing goes through a surface within it: the forces over a shorter
  // interval, and the displacement of `settle`, are not those that the contact time was found with.
  bool stop_short(double& tau);
  std::optional<double> passes_at(const ColliderPair& pair, double tau) const;
  // Earliest time in (0, tau) at which a sliding contact comes to stick, else tau.
  double next_stick_time(double tau);
  void find_again();
  void find_partners();  // and the reference velocity
  void move_partners(double t);
  double piece_of(double left) const;
  double coarse_piece_of(double h, double left) const;
  double turning_rate(const Contact& c) const;

  bool touches(const ColliderPair& pair) const;
  bool is_covered(const ColliderPair& pair) const;
  bool stays_on_plane(const ColliderPair& pair, double t) const;
  Pose pose_at(std::int32_t row, double t) const;
  std::optional<double> impact_of_pair(const ColliderPair& pair, double t_max) const;
  double closing_bound(const ColliderPair& pair, double t) const;
  double turning_bound(const Collider& c, double t) const;
  Vec3 acceleration_of(std::int32_t row) const;
  bool stays_apart(const ColliderPair& pair, const Vec3& n, double t) const;
  double approach_of_pair(const ColliderPair& pair, double t);
  SolverSettings solver_settings() const;
  double rest_speed(const Contact& c) const;
  bool rebound_ahead(double left) const;
  void add_impulse(Contact& c, const ContactConstraint& k, const Vec3& impulse, const Vec3& moment);
  bool approaches();
  void look_who_carried();
  bool drifts(std::int32_t contact, double speed) const;
  bool turning(double tau) const;
  void build_midpoint(const BodyIndex& index, double tau);

  std::vector<RigidState>& start_ = work_.start;          // saved states, per body of the island
  std::vector<std::int32_t>& partners_ = work_.partners;  // kinematic bodies the island may meet
  std::vector<RigidState>& partner_start_ = work_.partner_start;
  std::vector<Wrench>& total_ = work_.total;            // external + contact, per body
  std::vector<std::int32_t>& active_ = work_.active;    // contact of each constraint
  std::vector<Vec3>& slip_before_ = work_.slip_before;  // u at the start of carry, contact frame
  // World axes, m/s, of every contact that touches: what `strike` found, where it changed nothing.
  std::vector<Vec3>& relative_velocity_ = work_.relative_velocity;
  bool relative_known_ = false;
  std::vector<ContactDrift>& drifts_ = work_.drifts;  // per constraint
  std::vector<Vec6>& shift_ = work_.shift;            // m, rad; per body, or empty
  bool pushed_ = false;                               // the shift is one that no momentum sees
  bool among_others_ = false;  // contacts of other islands are in the list, too
  bool free_ = false;          // nothing immovable within reach: all momenta are the island's own
  bool at_start_ = false;      // the arms of the last solve are those at the start of its interval
  Vec3 reference_ = Vec3::Zero();  // m/s: problems are set up in the frame that moves along
  double residual_ = 0.0;          // of the last carry: only the one that moves the bodies counts
  double elapsed_ = 0.0;           // s since the step began
  ColliderPair met_;               // what the last contact time is of
  std::int64_t caps_before_ = 0;   // iteration_caps() when the step began
  bool hurried_ = false;           // the usual events are used up: contact times are rougher
};

}  // namespace rb
