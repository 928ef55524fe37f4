#include "lode/models/diamond/encode_blocks.h"

#include <algorithm>
#include <iterator>

#include "lode/core/parallel.h"
#include "lode/models/diamond/block_values.h"
#include "lode/models/diamond/range_code.h"

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

template <int D, typename T>
store::EncodedBlock encode_values(const Region<D>& r, const std::vector<T>& values) {
  store::ElementGrid grid{{1, 1, 1}, !r.has_coarser_points};
  for (std::size_t a = 0; a < as_size(D); ++a)
    grid.n[a] = static_cast<std::uint16_t>(r.upper[a] - r.lower[a]);
  return store::encode_block({std::as_bytes(std::span<const T>(values)), sizeof(T), grid});
}

template <int D, typename Field>
void encode_group(const Field& field, const WorldErrors& worlds, const Index<D>& origin,
                  const BlockGroup<D>& group, PendingBlocks& out) {
  visit_block_values<D>(field, worlds, origin, group, [&](Kind kind, const auto& values) {
    out.push_back({key_of(kind, group.region), encode_values<D>(group.region, values)});
  });
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
