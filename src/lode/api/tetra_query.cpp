#include "lode/api/tetra_query.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "lode/models/tetra_mt/region_masks.h"

namespace lode {
namespace {

/// As for volumes.
constexpr double kShareOfRange = 0.005;

/// A demand with bounds a little wider than they are: mesh vertices near a section count as in it.
struct WidenedDemand {
  Demand demand;
  double widening = 0;  ///< World units.

  [[nodiscard]] double operator()(const NodeFacts& node) const { return demand(widened(node)); }
  [[nodiscard]] bool touches(const NodeFacts& node) const { return demand.touches(widened(node)); }

 private:
  [[nodiscard]] NodeFacts widened(NodeFacts node) const {
    node.bounds.radius += widening;
    return node;
  }
};

/// Whether a text is its name or number.
template <typename Named>
bool is_called(const Named& named, const std::string& text) {
  return name_of(named) == text || std::to_string(named.id) == text;
}

std::string list_names(std::vector<std::string> names) {
  constexpr std::size_t kMost = 20;
  if (names.empty()) return "none";
  const std::size_t n_more = names.size() - std::min(names.size(), kMost);
  names.resize(names.size() - n_more);
  if (n_more > 0) names.push_back(fmt::format("{} more", n_more));
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string list_regions(const TetraInfo& info) {
  std::vector<std::string> names;
  for (const MeshRegion& region : info.regions)
    names.push_back(region.name.empty() ? std::to_string(region.id)
                                        : fmt::format("{} ({})", region.name, region.id));
  return list_names(std::move(names));
}

Error no_region(const TetraInfo& info, const std::string& got) {
  if (info.regions.empty())
    return fail("regions: expected none, as the mesh has none, got {}", got);
  return fail("regions: expected one of {}, got {}", list_regions(info), got);
}

}  // namespace

Result<Query> complete_query(const TetraFieldInfo& field, Query query,
                             const std::optional<double>& deadline_s) {
  if (needs_world_errors(query) && !field.base_world_error)
    return fail(
        "{}: expected a model that knows its space errors with a tolerance of them, or of pixels; "
        "got one that was built without",
        field.name);
  if (deadline_s && !(*deadline_s >= 0))
    return fail("deadline: expected a number >= 0, got {}", *deadline_s);
  // Of one value: any mesh has no error, and 0 would ask for the finest.
  const double range = field.range_max - field.range_min;
  const double share = range > 0 ? kShareOfRange * range : std::numeric_limits<double>::infinity();
  if (!query.max_error && !needs_world_errors(query))
    query.max_error = query.budget.is_limited() || deadline_s ? 0 : share;
  LODE_CHECK(check_query(query));
  return query;
}

Result<std::vector<std::uint32_t>> find_patches(const TetraInfo& info,
                                                std::span<const std::string> wanted) {
  std::vector<std::uint32_t> places;
  for (const std::string& text : wanted) {
    const std::size_t before = places.size();
    for (std::uint32_t i = 0; i < info.patches.size(); ++i)
      if (is_called(info.patches[i], text)) places.push_back(i);
    if (places.size() > before) continue;
    if (info.patches.empty())
      return fail("patches: expected none, as the mesh has none, got {}", text);
    std::vector<std::string> names;
    for (const BoundaryPatch& patch : info.patches) names.push_back(name_of(patch));
    return fail("patches: expected one of {}, got {}", list_names(std::move(names)), text);
  }
  return places;
}

Result<std::vector<std::int64_t>> find_regions(const TetraInfo& info,
                                               std::span<const std::string> wanted) {
  std::vector<std::int64_t> ids;
  for (const std::string& text : wanted) {
    const std::size_t before = ids.size();
    for (const MeshRegion& region : info.regions)
      if (is_called(region, text)) ids.push_back(region.id);
    if (ids.size() == before) return no_region(info, text);
  }
  return ids;
}

Result<void> check_regions(const TetraInfo& info, std::span<const std::int64_t> regions) {
  for (const std::int64_t id : regions)
    if (std::ranges::find(info.regions, id, &MeshRegion::id) == info.regions.end())
      return no_region(info, fmt::format("{}", id));
  return {};
}

Result<void> check_fields(const TetraInfo& info, const TetraFieldUse& use) {
  std::size_t last = use.measured;
  for (const std::size_t field : use.along) last = std::max(last, field);
  if (last < info.fields.size()) return {};
  return fail("fields: expected places of {}, got {}", info.fields.size(), last);
}

Demand demand_of(Query query, double widening) {
  const std::optional<double> outside = std::exchange(query.max_error_outside, std::nullopt);
  Demand demand = to_demand(query);
  const ErrorUnit unit = query.max_error         ? ErrorUnit::field
                         : query.max_world_error ? ErrorUnit::world
                                                 : ErrorUnit::pixels;
  if (!query.sections.empty()) demand = WidenedDemand{std::move(demand), widening};
  if (!outside) return demand;
  FocusDemand elsewhere{.foci = {}, .inside = *outside, .unit = unit};
  if (query.view) elsewhere.view = to_view_focus(*query.view);
  return max_of({std::move(demand), std::move(elsewhere)});
}

Demand in_regions(Demand demand, const TetraInfo& info, std::span<const std::int64_t> regions) {
  if (regions.empty() || info.regions.size() <= 1) return demand;
  std::uint64_t wanted = 0;
  for (const std::int64_t id : regions) {
    const auto at = std::ranges::find(info.regions, id, &MeshRegion::id);
    wanted |= tetra_mt::region_bit(static_cast<std::uint32_t>(at - info.regions.begin()));
  }
  return within_regions(std::move(demand), wanted);
}

}  // namespace lode
