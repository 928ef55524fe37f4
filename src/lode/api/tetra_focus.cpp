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
  // With a tolerance of 0 a demand is the error, as opacity weighs it, and never quite 0.
  if (is_weighed_) {
    focused.max_error = 0;
    focused.max_world_error.reset();
    focused.max_error_px.reset();
  }
  demand_ = in_regions(demand_of(std::move(focused), widening), info, regions);
}

double TetraFocus::error(const NodeFacts& facts) const {
  constexpr double kNegligible = 1e-29;
  if (!counts(facts)) return 0;
  if (!is_weighed_) return facts.error;
  const double weighed = demand_(facts);
  return weighed > kNegligible ? weighed : 0;
}

double TetraFocus::pixels(const NodeFacts& facts) const {
  if (!counts(facts)) return 0;
  double most = 0;
  for (const FocusDemand& of : pixels_) most = std::max(most, of.error(facts));
  return most;
}

}  // namespace lode
