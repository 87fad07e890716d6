// Contact times of shapes in motion: which search looks for whose.
#include <cmath>
#include <limits>
#include <stdexcept>

#include "collision/certified_search.hpp"
#include "collision/moving_pair.hpp"
#include "collision/queries.hpp"
#include "collision/surface_contacts.hpp"
#include "collision/sweep.hpp"
#include "shape/compound.hpp"

namespace rb {

void keep_earlier(ImpactSearch& best, const ImpactSearch& other) {
  best.iterations += other.iterations;
  if (!other.time || (best.time && *best.time <= *other.time)) return;
  best.time = other.time;
  best.converged = other.converged;
}

ImpactSearch find_time_of_impact(const Shape& a, const Sweep& motion_a, const Shape& b,
                                 const Sweep& motion_b, double t_max, int most_queries) {
  if (!(t_max >= 0.0) || !std::isfinite(t_max)) {
    throw std::invalid_argument("time_of_impact: t_max must be finite and >= 0");
  }
  if (const auto* compound = std::get_if<Compound>(&a)) {
    ImpactSearch best;
    for (const CompoundPart& part : compound->data->parts) {
      const PartSweep motion(motion_a, part.pose);
      keep_earlier(best, find_time_of_impact(part.shape, motion, b, motion_b,
                                             best.time.value_or(t_max), most_queries));
    }
    return best;
  }
  if (std::holds_alternative<Compound>(b)) {
    return find_time_of_impact(b, motion_b, a, motion_a, t_max, most_queries);
  }
  const auto is_scenery = [](const Shape& s) {
    return is_surface(s) || std::holds_alternative<HalfSpace>(s);
  };
  if (is_scenery(a) && is_scenery(b)) {
    throw std::invalid_argument(
        "time_of_impact: two half-spaces, meshes or height fields have no contact time");
  }
  if (is_surface(b)) return surface_time_of_impact(a, motion_a, b, motion_b, t_max, most_queries);
  if (is_surface(a)) return surface_time_of_impact(b, motion_b, a, motion_a, t_max, most_queries);
  const MovingPair pair(a, motion_a, b, motion_b, t_max);
  CertifiedSearch search(pair, 0.0, most_queries);
  search.run(std::numeric_limits<double>::infinity());
  return search.result();
}

}  // namespace rb
