#include "lode/api/tetra_focus.h"

#include <algorithm>
#include <utility>

#include "lode/api/tetra_query.h"

namespace lode {

TetraFocus::TetraFocus(const Query& query, double widening, const TetraInfo& info,
                       std::span<const std::int64_t> regions)
    : is_weighed_(!query.opacity.empty()) {
  if (query.view) view_ = to_view_focus(*query.view);
  Query focused = query;
  focused.max_error_outside.reset();
  pixels_ = pixel_measures(focused);
  const auto demand = [&](std::optional<double> field, std::optional<double> world,
                          std::optional<double> pixels) {
    Query one = focused;
    one.max_error = field;
    one.max_world_error = world;
    one.max_error_px = pixels;
    return in_regions(demand_of(std::move(one), widening), info, regions);
  };
  if (!is_weighed_) {
    demand_ = in_regions(demand_of(focused, widening), info, regions);
    return;
  }
  demand_ = demand(0, {}, {});
  world_demand_ = demand({}, 0, {});
  if (query.view) pixel_demand_ = demand({}, {}, 0);
}

double TetraFocus::weighed(const Demand& demand, const NodeFacts& facts) {
  constexpr double kNegligible = 1e-29;
  const double error = demand(facts);
  return error > kNegligible ? error : 0;
}

double TetraFocus::error(const NodeFacts& facts) const {
  if (!counts(facts)) return 0;
  return is_weighed_ ? weighed(demand_, facts) : facts.error;
}

double TetraFocus::world_error(const NodeFacts& facts) const {
  if (!counts(facts)) return 0;
  return is_weighed_ ? weighed(world_demand_, facts) : facts.world_error;
}

double TetraFocus::pixels(const NodeFacts& facts) const {
  if (!counts(facts)) return 0;
  if (is_weighed_) return weighed(pixel_demand_, facts);
  double most = 0;
  for (const FocusDemand& of : pixels_) most = std::max(most, of.error(facts));
  return most;
}

}  // namespace lode
