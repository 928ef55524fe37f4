#include "lode/models/diamond/encode_blocks.h"

#include <algorithm>
#include <iterator>

#include "lode/core/parallel.h"
#include "lode/models/diamond/range_code.h"
#include "lode/models/diamond/sample_rows.h"

namespace lode::diamond {
namespace {

/// Decoded bytes of the blocks that an index stands before. They wait in memory until all are
/// compressed; as few, so that what a damaged index loses is small, and an index (some 300 bytes
/// and 15 a block) is less than 0.1 % of what most fields compress to. Part of a file's bytes.
constexpr std::uint64_t kRunBytes = std::uint64_t{8} << 20;

using PendingBlocks = std::vector<store::KeyedBlock>;

/// Gathers groups to runs, by their decoded sizes alone: how many are compressed side by side
/// changes no byte of the file.
class RunWriter {
 public:
  explicit RunWriter(store::Writer& writer) : writer_(writer) {}

  Result<void> append(PendingBlocks& group) {
    std::uint64_t n_bytes = 0;
    for (const store::KeyedBlock& block : group) n_bytes += block.block.raw_size;
    if (n_bytes_ + n_bytes > kRunBytes) LODE_CHECK(flush());
    std::ranges::move(group, std::back_inserter(run_));
    n_bytes_ += n_bytes;
    group.clear();
    return {};
  }
  Result<void> flush() {
    LODE_CHECK(writer_.append_run(run_));
    run_.clear();
    n_bytes_ = 0;
    return {};
  }

 private:
  store::Writer& writer_;
  PendingBlocks run_;
  std::uint64_t n_bytes_ = 0;
};

/// Infinite ends are the type's.
template <typename R>
R to_range(float v) {
  constexpr auto kLowest = static_cast<float>(std::numeric_limits<R>::lowest());
  constexpr auto kHighest = static_cast<float>(std::numeric_limits<R>::max());
  if constexpr (std::is_integral_v<R>) return static_cast<R>(std::clamp(v, kLowest, kHighest));
  return static_cast<R>(v);
}

/// A number for each of the region's points, in their order.
template <int D, typename T>
store::EncodedBlock encode_values(const Region<D>& r, const std::vector<T>& values) {
  store::ElementGrid grid{{1, 1, 1}, !r.has_coarser_points};
  for (std::size_t a = 0; a < as_size(D); ++a)
    grid.n[a] = static_cast<std::uint16_t>(r.upper[a] - r.lower[a]);
  return store::encode_block({std::as_bytes(std::span<const T>(values)), sizeof(T), grid});
}

template <int D, typename Field>
void encode_samples(const Field& field, const store::BlockKey& key, const Region<D>& r,
                    PendingBlocks& out) {
  visit_storage_type(field.storage, [&]<typename T>() {
    std::vector<T> values(count_points(r));
    T* to = values.data();
    for_each_row<D>(r, [&](Index<D> q, std::int32_t n, std::int32_t stride) {
      for (std::int32_t& x : q.v) x <<= r.level;
      to = copy_samples<T, D>(field, q, n, stride << r.level, to);
    });
    out.push_back({key, encode_values<D, T>(r, values)});
  });
}

/// to[i] = convert(a[i · stride], b[i · stride]).
template <typename T, typename A, typename B, typename Convert>
void convert_row(const A* __restrict a, const B* __restrict b, std::size_t n, std::size_t stride,
                 const Convert& convert, T* __restrict to) {
  if (stride == 1)
    for (std::size_t i = 0; i < n; ++i) to[i] = convert(a[i], b[i]);
  else
    for (std::size_t i = 0; i < n; ++i) to[i] = convert(a[2 * i], b[2 * i]);
}

/// One attribute of the region's nodes, from two arrays of their level.
template <typename T, int D, typename A, typename B, typename Convert>
void encode_attribute(const Index<D>& dims, const store::BlockKey& key, const Region<D>& r,
                      const A* a, const B* b, const Convert& convert, PendingBlocks& out) {
  std::vector<T> values(count_points(r));
  T* to = values.data();
  for_each_row<D>(r, [&](const Index<D>& q, std::int32_t n, std::int32_t stride) {
    const std::size_t first = linear_index<D>(dims, q);
    convert_row(a + first, b + first, as_size(n), as_size(stride), convert, to);
    to += n;
  });
  out.push_back({key, encode_values<D, T>(r, values)});
}

template <int D, typename Field>
void encode_attributes(const Field& field, const WorldErrors& worlds, const Region<D>& place,
                       const Region<D>& r, PendingBlocks& out) {
  const NodeLevel& nodes = field.levels[as_size(r.level)];
  const Index<D> dims = field.shape.grid_dims(r.level);
  const auto as_it_is = [](auto value, auto) { return value; };
  const ErrorCode* const errors = nodes.error.data();
  encode_attribute<ErrorCode>(dims, key_of(Kind::errors, place), r, errors, errors, as_it_is, out);
  visit_range_type(field.storage, [&]<typename R>() {
    const auto low = [](float l, float h) {
      return l > h ? std::numeric_limits<R>::max() : to_range<R>(l);
    };
    const auto high = [](float l, float h) {
      return l > h ? std::numeric_limits<R>::lowest() : to_range<R>(h);
    };
    const float* const lows = nodes.low.data();
    const float* const highs = nodes.high.data();
    encode_attribute<R>(dims, key_of(Kind::lows, place), r, lows, highs, low, out);
    encode_attribute<R>(dims, key_of(Kind::highs, place), r, lows, highs, high, out);
  });
  const WorldCode* const codes = worlds[as_size(r.level)].data();
  encode_attribute<WorldCode>(dims, key_of(Kind::worlds, place), r, codes, codes, as_it_is, out);
}

template <int D, typename Field>
void encode_group(const Field& field, const WorldErrors& worlds, const Index<D>& origin,
                  const BlockGroup<D>& group, PendingBlocks& out) {
  Region<D> r = group.region;
  if (count_points(r) == 0) return;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    r.lower[i] -= origin[i] >> r.level;
    r.upper[i] -= origin[i] >> r.level;
  }
  if (group.is_samples)
    encode_samples<D>(field, key_of(Kind::samples, group.region), r, out);
  else
    encode_attributes<D>(field, worlds, group.region, r, out);
}

}  // namespace

template <int D, typename Field>
Result<void> append_groups(const Field& field, const WorldErrors& worlds, const Index<D>& origin,
                           std::span<const BlockGroup<D>> groups, store::Writer& writer,
                           Threads threads, const Progress& progress) {
  // A few at a time: what is compressed waits in memory.
  const std::size_t batch = 8 * as_size(n_workers(threads));
  std::vector<PendingBlocks> pending(batch);
  RunWriter run(writer);
  for (std::size_t first = 0; first < groups.size(); first += batch) {
    const std::size_t n = std::min(batch, groups.size() - first);
    parallel_for(n, threads, 1, [&](std::size_t i, int) {
      pending[i].clear();
      if (!progress.is_cancelled())
        encode_group<D>(field, worlds, origin, groups[first + i], pending[i]);
    });
    for (std::size_t i = 0; i < n; ++i) {
      if (progress.is_cancelled()) return cancelled_error();
      LODE_CHECK(run.append(pending[i]));
    }
  }
  if (progress.is_cancelled()) return cancelled_error();
  return run.flush();
}

template <int D, typename Field>
void round_ranges(const LatticeField<D, Field>& field, std::vector<NodeLevel>& levels, int first,
                  Threads threads) {
  if (has_exact_ranges(field.storage)) return;
  constexpr std::size_t kChunk = 4096;
  const double reference = field.range_reference();
  const std::array<float, 2> whole{range_down(field.stats.min, reference),
                                   range_up(field.stats.max, reference)};
  for (std::size_t level = as_size(first); level < levels.size(); ++level) {
    NodeLevel& nodes = levels[level];
    const std::size_t n = nodes.error.size();
    parallel_for((n + kChunk - 1) / kChunk, threads, 1, [&](std::size_t chunk, int) {
      for (std::size_t at = chunk * kChunk; at < std::min(n, (chunk + 1) * kChunk); ++at)
        round_range(whole, nodes.low[at], nodes.high[at]);
    });
  }
}

template Result<void> append_groups<2>(const Model<2>&, const WorldErrors&, const Index<2>&,
                                       std::span<const BlockGroup<2>>, store::Writer&, Threads,
                                       const Progress&);
template Result<void> append_groups<3>(const Model<3>&, const WorldErrors&, const Index<3>&,
                                       std::span<const BlockGroup<3>>, store::Writer&, Threads,
                                       const Progress&);
template Result<void> append_groups<2>(const CoarseField<2>&, const WorldErrors&, const Index<2>&,
                                       std::span<const BlockGroup<2>>, store::Writer&, Threads,
                                       const Progress&);
template Result<void> append_groups<3>(const CoarseField<3>&, const WorldErrors&, const Index<3>&,
                                       std::span<const BlockGroup<3>>, store::Writer&, Threads,
                                       const Progress&);
template void round_ranges<2>(const LatticeField<2, Model<2>>&, std::vector<NodeLevel>&, int,
                              Threads);
template void round_ranges<3>(const LatticeField<3, Model<3>>&, std::vector<NodeLevel>&, int,
                              Threads);
template void round_ranges<2>(const LatticeField<2, CoarseField<2>>&, std::vector<NodeLevel>&, int,
                              Threads);
template void round_ranges<3>(const LatticeField<3, CoarseField<3>>&, std::vector<NodeLevel>&, int,
                              Threads);

}  // namespace lode::diamond
