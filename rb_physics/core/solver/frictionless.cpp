#include "solver/frictionless.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace rb {
namespace {

constexpr double kDependent = 1e-7;  // of A_ii: pivots below it are left to methods that regularise
constexpr double kInconsistent = 1e-9;  // of the fastest d: what dependent contacts may approach
constexpr std::size_t kFew = 12;        // contacts: their order makes no difference
constexpr double kNoise = 4e-15;        // of the fastest d
constexpr int kBlocks = 3;              // block exchanges that gain nothing before a single one
constexpr double kSoft = 1e-6;          // of A_ii: added to it where contacts depend on each other
constexpr double kPull = 1e-2;          // rounding of a speed over that of what a force does there
constexpr double kSoftNoise = 1e-11;    // of the fastest d
constexpr int kMostCentres = 8;
constexpr double kMostFactors = 10.0;  // of the largest size

double dot(const double* x, const double* y, std::ptrdiff_t n) {
  double s0 = 0.0, s1 = 0.0, s2 = 0.0, s3 = 0.0;
  std::ptrdiff_t k = 0;
  for (; k + 4 <= n; k += 4) {
    s0 += x[k] * y[k];
    s1 += x[k + 1] * y[k + 1];
    s2 += x[k + 2] * y[k + 2];
    s3 += x[k + 3] * y[k + 3];
  }
  for (; k < n; ++k) s0 += x[k] * y[k];
  return (s0 + s1) + (s2 + s3);
}

struct Pivoting {
  using Row = FrictionlessWorkspace::Row;
  const ContactProblem& problem;
  const FrictionlessOptions& options;
  FrictionlessWorkspace& ws;
  FrictionlessReport& report;
  double fastest = 0.0;   // m/s, of d
  double rounding = 0.0;  // m/s
  bool dependent = false, factored = false;
  double soft = 0.0;  // kSoft once contacts were found to depend on each other

  double motion(const Row& r, const std::vector<Vec6>& v) const {
    double s = r.normal.dot(v[r.a].head<3>()) + r.turn_a.dot(v[r.a].tail<3>());
    if (r.b >= 0) s -= r.normal.dot(v[r.b].head<3>()) + r.turn_b.dot(v[r.b].tail<3>());
    return s;
  }

  void push(const Row& r, double f, std::vector<Vec6>& v) const {
    v[r.a].head<3>() += (f * problem.inv_mass[r.a]) * r.normal;
    v[r.a].tail<3>() += f * r.response_a;
    if (r.b < 0) return;
    v[r.b].head<3>() -= (f * problem.inv_mass[r.b]) * r.normal;
    v[r.b].tail<3>() -= f * r.response_b;
  }

  void load() {
    const std::size_t nc = problem.contacts.size();
    const std::size_t nb = problem.inv_mass.size();
    ws.rows.resize(nc);
    ws.first_of_body.assign(nb + 1, 0);
    for (std::size_t i = 0; i < nc; ++i) {
      const ContactConstraint& c = problem.contacts[i];
      Row& r = ws.rows[i];
      r.a = c.a;
      r.b = c.b;
      r.normal = c.frame.row(0).transpose();
      r.turn_a = c.r_a.cross(r.normal);
      r.response_a = problem.inv_inertia[c.a] * r.turn_a;
      r.diagonal = problem.inv_mass[c.a] * r.normal.squaredNorm() + r.turn_a.dot(r.response_a);
      ++ws.first_of_body[c.a];
      if (c.b >= 0) {
        r.turn_b = c.r_b.cross(r.normal);
        r.response_b = problem.inv_inertia[c.b] * r.turn_b;
        r.diagonal += problem.inv_mass[c.b] * r.normal.squaredNorm() + r.turn_b.dot(r.response_b);
        ++ws.first_of_body[c.b];
      }
      r.d = motion(r, problem.velocity) + c.bias.x();
      fastest = std::max(fastest, std::abs(r.d));
    }
    std::int32_t sum = 0;
    for (std::int32_t& n : ws.first_of_body) {
      sum += n;
      n = sum;
    }
    ws.of_body.resize(sum);
    for (std::size_t i = nc; i-- > 0;) {
      const Row& r = ws.rows[i];
      ws.of_body[--ws.first_of_body[r.a]] = static_cast<std::int32_t>(i);
      if (r.b >= 0) ws.of_body[--ws.first_of_body[r.b]] = static_cast<std::int32_t>(i);
    }
  }

  // What A has beside its diagonal: two contacts of a body each.
  void couple() {
    const std::size_t nc = ws.rows.size();
    const auto of_body = [&](std::size_t body) {
      return std::pair(ws.first_of_body[body], ws.first_of_body[body + 1]);
    };
    ws.first_coupling.assign(nc + 1, 0);
    for (std::size_t i = 0; i < nc; ++i) {
      for (const std::int32_t body : {ws.rows[i].a, ws.rows[i].b}) {
        if (body < 0) continue;
        const auto [begin, end] = of_body(body);
        ws.first_coupling[i + 1] += end - begin - 1;
      }
    }
    for (std::size_t i = 0; i < nc; ++i) ws.first_coupling[i + 1] += ws.first_coupling[i];
    ws.next_coupling.assign(ws.first_coupling.begin(), ws.first_coupling.end() - 1);
    ws.couplings.resize(ws.first_coupling.back());
    for (std::size_t body = 0; body + 1 < ws.first_of_body.size(); ++body) {
      const auto [begin, end] = of_body(body);
      for (std::int32_t x = begin; x < end; ++x) {
        const std::int32_t i = ws.of_body[x];
        const Row& r = ws.rows[i];
        const bool of_a = r.a == static_cast<std::int32_t>(body);
        const Vec3& turn = of_a ? r.turn_a : r.turn_b;
        for (std::int32_t y = x + 1; y < end; ++y) {
          const std::int32_t j = ws.of_body[y];
          const Row& other = ws.rows[j];
          const bool other_a = other.a == static_cast<std::int32_t>(body);
          const double s = problem.inv_mass[body] * r.normal.dot(other.normal) +
                           turn.dot(other_a ? other.response_a : other.response_b);
          const double value = of_a == other_a ? s : -s;
          ws.couplings[ws.next_coupling[i]++] = {j, value};
          ws.couplings[ws.next_coupling[j]++] = {i, value};
        }
      }
    }
  }

  std::span<const FrictionlessWorkspace::Coupling> couplings_of(std::int32_t i) const {
    return std::span(ws.couplings)
        .subspan(ws.first_coupling[i], ws.first_coupling[i + 1] - ws.first_coupling[i]);
  }

  // Those that can be reached from contact i, in breadth; appended to the order.
  void walk(std::int32_t i) {
    std::size_t at = ws.all.size();
    ws.all.push_back(i);
    ws.place[i] = 0;
    for (; at < ws.all.size(); ++at) {
      for (const auto& [j, value] : couplings_of(ws.all[at])) {
        if (ws.place[j] >= 0) continue;
        ws.place[j] = 0;
        ws.all.push_back(j);
      }
    }
  }

  void sort() {
    const auto nc = static_cast<std::int32_t>(ws.rows.size());
    ws.all.clear();
    ws.place.assign(nc, -1);
    for (std::int32_t i = 0; i < nc; ++i) {
      if (ws.place[i] >= 0) continue;
      if (ws.rows.size() <= kFew) {
        ws.all.push_back(i);
        continue;
      }
      // From the far end of it.
      const std::size_t from = ws.all.size();
      walk(i);
      const std::int32_t end = ws.all.back();
      for (std::size_t k = from; k < ws.all.size(); ++k) ws.place[ws.all[k]] = -1;
      ws.all.resize(from);
      walk(end);
    }
    std::reverse(ws.all.begin(), ws.all.end());
    ws.order.clear();
  }

  // Those that carry, in order; returns how many of the first are those of the last time.
  std::size_t list_carrying() {
    std::size_t n = 0, same = 0;
    const std::size_t before = ws.order.size();
    ws.order.resize(ws.rows.size());
    for (const std::int32_t i : ws.all) {
      if (!ws.carries[i]) continue;
      if (same == n && n < before && ws.order[n] == i) ++same;
      ws.order[n] = i;
      ws.place[i] = static_cast<std::int32_t>(n++);
    }
    ws.order.resize(n);
    return same;
  }

  bool factorize() {
    if (!factored) ws.order.clear();
    const std::size_t same = list_carrying();
    factored = false;
    const std::size_t n = ws.order.size();
    ws.first.resize(n);
    ws.start.resize(n + 1);
    ws.inverse.resize(n);
    double work = 0.0;
    std::int32_t size = same > 0 ? ws.start[same] : 0;
    for (std::size_t p = same; p < n; ++p) {
      auto first = static_cast<std::int32_t>(p);
      for (const auto& [j, value] : couplings_of(ws.order[p])) {
        if (ws.carries[j]) first = std::min(first, ws.place[j]);
      }
      const auto width = static_cast<std::int32_t>(p) - first;
      ws.first[p] = first;
      ws.start[p] = size;
      size += width;
      work += 20.0 + 0.5 * width * width;
    }
    ws.start[n] = size;
    if (work > options.max_work || report.work > kMostFactors * options.max_work) return false;
    report.work += work;
    ++report.factorizations;
    ws.lower.resize(size);
    std::fill(ws.lower.begin() + (same < n ? ws.start[same] : size), ws.lower.end(), 0.0);
    for (std::size_t p = same; p < n; ++p) {
      const Row& r = ws.rows[ws.order[p]];
      const std::int32_t first = ws.first[p];
      double* row = ws.lower.data() + ws.start[p];  // row[column - first]
      for (const auto& [j, value] : couplings_of(ws.order[p])) {
        if (ws.carries[j] && ws.place[j] < static_cast<std::int32_t>(p))
          row[ws.place[j] - first] += value;
      }
      double pivot = (1.0 + soft) * r.diagonal;
      for (std::int32_t q = first; q < static_cast<std::int32_t>(p); ++q) {
        const std::int32_t from = std::max(first, ws.first[q]);
        const double* other = ws.lower.data() + ws.start[q];
        double& entry = row[q - first];
        entry -= dot(row + (from - first), other + (from - ws.first[q]), q - from);
        entry *= ws.inverse[q];
        pivot -= entry * entry;
      }
      if (pivot > (soft > 0.0 ? 0.1 * soft : kDependent) * r.diagonal) {
        ws.inverse[p] = 1.0 / std::sqrt(pivot);
        continue;
      }
      if (options.unique || soft > 0.0) return false;
      dependent = true;
      soft = kSoft;
      rounding = std::max(rounding, kSoftNoise * fastest);
      return factorize();
    }
    return factored = true;
  }

  // A x = right, in place, in the order of the factor.
  void back_substitute(std::vector<double>& x) const {
    const auto n = static_cast<std::int32_t>(ws.order.size());
    for (std::int32_t p = 0; p < n; ++p) {
      const double* row = ws.lower.data() + ws.start[p];
      x[p] = (x[p] - dot(row, x.data() + ws.first[p], p - ws.first[p])) * ws.inverse[p];
    }
    for (std::int32_t p = n - 1; p >= 0; --p) {
      x[p] *= ws.inverse[p];
      const double* row = ws.lower.data() + ws.start[p];
      for (std::int32_t q = ws.first[p]; q < p; ++q) x[q] -= row[q - ws.first[p]] * x[p];
    }
  }

  // Speeds of all contacts under the forces there are.
  void measure() {
    ws.velocity = problem.velocity;
    for (const std::int32_t i : ws.order) push(ws.rows[i], ws.force[i], ws.velocity);
    for (std::size_t i = 0; i < ws.rows.size(); ++i) {
      ws.speed[i] = motion(ws.rows[i], ws.velocity) + problem.contacts[i].bias.x();
      ws.speed[i] += soft * ws.rows[i].diagonal * (ws.force[i] - ws.centre[i]);
    }
  }

  void correct() {
    ws.right.resize(ws.order.size());
    for (std::size_t p = 0; p < ws.order.size(); ++p) ws.right[p] = -ws.speed[ws.order[p]];
    back_substitute(ws.right);
    for (std::size_t p = 0; p < ws.order.size(); ++p) ws.force[ws.order[p]] += ws.right[p];
    measure();
  }

  bool forces() {
    if (!factorize()) return false;
    const std::size_t nc = ws.rows.size();
    ws.force.assign(nc, 0.0);
    ws.speed.resize(nc);
    for (std::size_t i = 0; i < nc; ++i)
      ws.speed[i] = ws.rows[i].d - soft * ws.rows[i].diagonal * ws.centre[i];
    correct();
    double left = 0.0;
    for (const std::int32_t i : ws.order) left = std::max(left, std::abs(ws.speed[i]));
    if (left > 0.1 * rounding) correct();
    return true;
  }

  // Carries what pulls, or approaches and carries nothing.
  bool is_wrong(std::size_t i) const {
    if (!ws.carries[i]) return ws.speed[i] < -rounding;
    return ws.force[i] * ws.rows[i].diagonal < -rounding / (soft > 0.0 ? kPull : 1.0);
  }

  bool exchange() {
    const std::size_t nc = ws.rows.size();
    std::size_t fewest = nc + 1;
    int blocks = kBlocks;
    const std::size_t most = 20 + nc;
    for (std::size_t n = 0; n < most; ++n) {
      if (!forces()) return false;
      std::size_t wrong = 0, last = 0;
      for (std::size_t i = 0; i < nc; ++i) {
        if (!is_wrong(i)) continue;
        ++wrong;
        last = i;
      }
      if (wrong == 0) return true;
      if (wrong < fewest) {
        fewest = wrong;
        blocks = kBlocks;
      } else {
        --blocks;
      }
      if (blocks <= 0) {
        ws.carries[last] ^= 1;
        continue;
      }
      for (std::size_t i = 0; i < nc; ++i) ws.carries[i] ^= is_wrong(i);
    }
    return false;
  }

  // Where contacts depend on each other: the proximal point method, from no forces, whose every
  // step has one answer.
  bool run() {
    ws.centre.assign(ws.rows.size(), 0.0);
    for (int k = 0; k < kMostCentres; ++k) {
      if (!exchange()) return false;
      if (soft == 0.0) return true;
      double left = 0.0;  // m/s
      for (std::size_t i = 0; i < ws.rows.size(); ++i) {
        const double force = std::max(ws.force[i], 0.0);
        left = std::max(left, soft * ws.rows[i].diagonal * std::abs(force - ws.centre[i]));
        ws.centre[i] = force;
      }
      if (left <= kInconsistent * fastest) return true;
    }
    return false;
  }
};

}  // namespace

FrictionlessReport solve_frictionless(const ContactProblem& problem,
                                      const FrictionlessOptions& options,
                                      const std::vector<Vec6>& velocity, FrictionlessWorkspace& ws,
                                      std::vector<Vec3>& impulse, std::vector<Vec6>& certificate) {
  FrictionlessReport report;
  Pivoting pivoting{problem, options, ws, report};
  pivoting.load();
  pivoting.couple();
  pivoting.sort();
  pivoting.rounding = std::max(options.rounding, kNoise * pivoting.fastest);
  const std::size_t nc = ws.rows.size();
  // What approaches under the forces of the guess will carry; without any, also what rests.
  const bool pushed =
      std::any_of(impulse.begin(), impulse.end(), [](const Vec3& f) { return f.x() > 0.0; });
  const double least = pushed ? pivoting.rounding : -pivoting.rounding;
  ws.carries.resize(nc);
  for (std::size_t i = 0; i < nc; ++i) {
    const double speed = pivoting.motion(ws.rows[i], velocity) + problem.contacts[i].bias.x();
    ws.carries[i] = ws.rows[i].diagonal * impulse[i].x() - speed > least;
  }
  if (!pivoting.run()) return report;
  report.solved = true;
  report.unique = !pivoting.dependent;
  for (std::size_t i = 0; i < nc; ++i)
    impulse[i] = Vec3(ws.carries[i] ? std::max(ws.force[i], 0.0) : 0.0, 0.0, 0.0);
  certificate.assign(problem.inv_mass.size(), Vec6::Zero());
  if (!report.unique) return report;
  ws.right.resize(ws.order.size());
  for (std::size_t p = 0; p < ws.order.size(); ++p) ws.right[p] = impulse[ws.order[p]].x();
  pivoting.back_substitute(ws.right);
  for (std::size_t p = 0; p < ws.order.size(); ++p)
    pivoting.push(ws.rows[ws.order[p]], ws.right[p], certificate);
  return report;
}

}  // namespace rb
