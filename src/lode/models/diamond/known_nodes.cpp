#include "lode/models/diamond/known_nodes.h"

#include <cmath>

#include "lode/models/diamond/range_code.h"

namespace lode::diamond {
namespace {

/// No error has this code, and no end of a range is NaN.
constexpr ErrorCode kUnknownError = 0xFFFF;
constexpr float kUnknownEnd = std::numeric_limits<float>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A block's values, or the first of them that is_possible refuses.
template <typename T, typename IsPossible>
Result<void> check_values(const store::Reader& reader, const store::BlockKey& key,
                          std::span<const std::byte> bytes, const IsPossible& is_possible) {
  for (std::size_t i = 0; i + sizeof(T) <= bytes.size(); i += sizeof(T)) {
    T value;
    std::memcpy(&value, bytes.data() + i, sizeof(T));
    if (!is_possible(value))
      return fail("{}: {}: expected what the metadata allow, got {}", reader.path(), describe(key),
                  value);
  }
  return {};
}

}  // namespace

template <int D>
KnownNodes<D>::KnownNodes(const Metadata& metadata) : max_errors_(metadata.summary.max_errors) {
  field_.set_info(metadata.info);
  field_.stats = metadata.summary.stats;
  levels_.resize(as_size(field_.shape.n_levels));
  for (int level = 1; level < field_.shape.n_levels; ++level) {
    const std::size_t n = n_points<D>(field_.shape.grid_dims(level));
    levels_[as_size(level)].error.assign(n, kUnknownError);
    levels_[as_size(level)].low.assign(n, kUnknownEnd);
    levels_[as_size(level)].high.assign(n, kUnknownEnd);
  }
}

template <int D>
Result<KnownNodes<D>> KnownNodes<D>::load(const store::Reader& reader, const Metadata& metadata,
                                          Threads threads, Progress& progress,
                                          std::vector<LostRegion<D>>& lost) {
  KnownNodes nodes(metadata);
  std::vector<LostRegion<D>> here;
  LODE_CHECK(nodes.load_errors(reader, threads, progress, here));
  LODE_CHECK(visit_range_type(nodes.field_.storage, [&]<typename R>() {
    return nodes.template load_ranges<R>(reader, threads, progress, here);
  }));
  nodes.complete(here, threads);
  lost.insert(lost.end(), here.begin(), here.end());
  return nodes;
}

template <int D>
Result<void> KnownNodes<D>::load_errors(const store::Reader& reader, Threads threads,
                                        Progress& progress, std::vector<LostRegion<D>>& lost) {
  const std::vector<Region<D>> regions = all_regions<D>(field_.shape, Kind::errors);
  const auto use = [&](std::size_t i, const std::vector<std::byte>& bytes) -> Result<void> {
    const Region<D>& r = regions[i];
    const double largest = max_errors_[as_size(r.level)];
    const auto is_possible = [&](ErrorCode code) {
      return code <= kInfiniteError && static_cast<double>(decode_error(code)) <= largest;
    };
    LODE_CHECK(check_values<ErrorCode>(reader, key_of(Kind::errors, r), bytes, is_possible));
    auto& to = levels_[as_size(r.level)].error;
    for_each_value<ErrorCode, D>(r, field_.shape.grid_dims(r.level), bytes.data(),
                                 [&](std::size_t at, ErrorCode code) { to[at] = code; });
    return {};
  };
  return salvage_blocks<D>(reader, regions, Kind::errors, sizeof(ErrorCode), threads, progress, use,
                           lost);
}

template <int D>
template <typename R>
Result<void> KnownNodes<D>::load_ranges(const store::Reader& reader, Threads threads,
                                        Progress& progress, std::vector<LostRegion<D>>& lost) {
  const double reference = field_.range_reference();
  const float low = range_down(field_.stats.min, reference);
  const float high = range_up(field_.stats.max, reference);
  const auto load_kind = [&](Kind kind, auto NodeLevel::*array, const auto& is_possible) {
    const std::vector<Region<D>> regions = all_regions<D>(field_.shape, kind);
    const auto use = [&](std::size_t i, const std::vector<std::byte>& bytes) -> Result<void> {
      const Region<D>& r = regions[i];
      LODE_CHECK(check_values<R>(reader, key_of(kind, r), bytes, is_possible));
      auto& to = levels_[as_size(r.level)].*array;
      for_each_value<R, D>(r, field_.shape.grid_dims(r.level), bytes.data(),
                           [&](std::size_t at, R end) { to[at] = static_cast<float>(end); });
      return {};
    };
    return salvage_blocks<D>(reader, regions, kind, sizeof(R), threads, progress, use, lost);
  };
  // What stands for an empty range, the type's largest number as the low end, is possible too.
  LODE_CHECK(load_kind(Kind::lows, &NodeLevel::low,
                       [&](R end) { return static_cast<float>(end) >= low; }));
  return load_kind(Kind::highs, &NodeLevel::high,
                   [&](R end) { return static_cast<float>(end) <= high; });
}

/// From the coarsest level down, and tier by tier: parents first.
template <int D>
void KnownNodes<D>::complete(std::span<const LostRegion<D>> lost, Threads threads) {
  for (int level = field_.shape.n_levels - 1; level > 0; --level) {
    std::vector<Region<D>> regions;
    for (const LostRegion<D>& block : lost) {
      const auto is_same = [&](const Region<D>& r) { return r.position == block.region.position; };
      if (block.region.level == level && std::ranges::none_of(regions, is_same))
        regions.push_back(block.region);
    }
    const Index<D> dims = field_.shape.grid_dims(level);
    for (int tier = 0; tier < D; ++tier)
      parallel_for(regions.size(), threads, 1, [&](std::size_t i, int) {
        for_each_row<D>(regions[i], [&](Index<D> q, std::int32_t n, std::int32_t stride) {
          for (std::int32_t k = 0; k < n; ++k, q[0] += stride) {
            const Diamond<D> node = diamond_at<D>(q * (std::int32_t{1} << level));
            if (node.tier == tier) complete(node, linear_index<D>(dims, q));
          }
        });
      });
  }
}

/// Each end of a range is true without the other: an empty one's low end is above all samples.
template <int D>
void KnownNodes<D>::complete(const Diamond<D>& node, std::size_t at) {
  NodeLevel& nodes = levels_[as_size(node.level)];
  ErrorCode& error = nodes.error[at];
  float& low = nodes.low[at];
  float& high = nodes.high[at];
  if (error != kUnknownError && !std::isnan(low) && !std::isnan(high)) return;
  const Facts facts = of_parents(node);
  const double reference = field_.range_reference();
  if (error == kUnknownError) error = encode_error(float_up(facts.error));
  if (std::isnan(low)) low = range_down(facts.low, reference);
  if (std::isnan(high)) high = range_up(facts.high, reference);
}

template <int D>
bool KnownNodes<D>::is_in_grid(const Index<D>& p, int level) const {
  const Index<D> dims = field_.shape.grid_dims(level);
  for (std::size_t i = 0; i < as_size(D); ++i)
    if (p[i] < 0 || (p[i] >> level) >= dims[i]) return false;
  return true;
}

template <int D>
typename KnownNodes<D>::Facts KnownNodes<D>::of_field(int level) const {
  return {field_.stats.min, field_.stats.max, max_errors_[as_size(level)]};
}

template <int D>
typename KnownNodes<D>::Facts KnownNodes<D>::of_parents(const Diamond<D>& node) const {
  Facts facts = of_field(node.level);
  for (const Index<D>& p : parents<D>(node, field_.shape.root_side())) {
    const Diamond<D> parent = diamond_at<D>(p);
    if (is_in_grid(p, parent.level)) facts.narrow(of_node(parent));
  }
  return facts;
}

template <int D>
typename KnownNodes<D>::Facts KnownNodes<D>::of_node(const Diamond<D>& node) const {
  if (node.level == 0) return of_parents(node);  // not stored
  const Index<D> dims = field_.shape.grid_dims(node.level);
  Index<D> q = node.centre;
  for (std::int32_t& x : q.v) x >>= node.level;
  const std::size_t at = linear_index<D>(dims, q);
  const NodeLevel& nodes = levels_[as_size(node.level)];
  const double reference = field_.range_reference();
  const auto error = static_cast<double>(decode_error(nodes.error[at]));
  if (nodes.low[at] > nodes.high[at]) return {kInfinity, -kInfinity, error};
  // Ends are rounded outward from reference, so their sums, rounded as they are, do not pass the
  // samples that they bound.
  return {reference + static_cast<double>(nodes.low[at]),
          reference + static_cast<double>(nodes.high[at]), error};
}

template <int D>
typename KnownNodes<D>::Facts KnownNodes<D>::at(const Index<D>& sample) const {
  const Shape<D>& shape = field_.shape;
  // Without cells no error is that of a sample.
  if (!shape.has_cells()) return {field_.stats.min, field_.stats.max, kInfinity};
  const int level = common_exponent<D>(sample);
  const bool is_corner = level >= shape.n_levels;  // of the root: the centre of no node
  Facts facts{field_.stats.min, field_.stats.max, kInfinity};
  if (!is_corner) facts.narrow(of_node(diamond_at<D>(sample)));
  if (level < 2 || shape.n_levels < 2) return facts;
  // It is also a corner of the smallest cubes whose ranges are stored: those are far narrower.
  for (std::uint32_t corner = 0; corner < 1U << D; ++corner) {
    Index<D> centre = sample;
    for (std::size_t i = 0; i < as_size(D); ++i) centre[i] += (corner >> i & 1U) != 0 ? 2 : -2;
    if (!is_in_grid(centre, 1)) continue;
    Facts cube = of_node(diamond_at<D>(centre));
    cube.error = kInfinity;
    facts.narrow(cube);
  }
  return facts;
}

template class KnownNodes<2>;
template class KnownNodes<3>;

}  // namespace lode::diamond
