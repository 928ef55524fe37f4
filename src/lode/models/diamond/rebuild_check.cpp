#include "lode/models/diamond/rebuild_check.h"

#include <cstring>

#include "lode/models/diamond/block_checks.h"
#include "lode/models/diamond/coarse_nesting.h"
#include "lode/models/diamond/field_scan.h"
#include "lode/models/diamond/file_samples.h"

namespace lode::diamond {
namespace {

/// Bytes that one takes whose parts have so many chunks side by side, without what it keeps of
/// blocks.
template <int D>
std::uint64_t rebuild_bytes(const VolumeInfo& info, std::int32_t chunks_per_part, int n_threads) {
  const Shape<D> shape = shape_of<D>(info.grid.dims);
  const PartPlan<D> largest = PartPlan<D>::largest(shape, chunks_per_part);
  const std::size_t size = size_of(storage_type(info.type));
  // For each thread what finding errors takes, a sample block, and a node block's values twice;
  // slices that are looked at, and what an allocator keeps of blocks that are gone.
  const std::uint64_t of_all = (32 + 8 * size) * n_points<D>(shape.dims);
  const std::uint64_t scratch = as_size(n_threads) * std::min(of_all, std::uint64_t{12} << 20);
  const std::uint64_t rest = std::min(of_all, std::uint64_t{48} << 20);
  return largest.n_bytes(size) + n_points<D>(largest.dims) * size +
         CoarseField<D>::n_bytes(info, true) + scratch + rest;
}

/// Range, holes and removed cells of a field, found part by part.
template <int D>
class PartStats {
 public:
  explicit PartStats(const CoarseField<D>& field) : field_(field) {}

  /// `samples`: of a box, x fastest, that holds the core and one layer more, where the data have
  /// it.
  void add(const LatticeBox<D>& core, const LatticeBox<D>& box, const std::byte* samples,
           Threads threads) {
    LatticeBox<D> cells = core;  // with all corners of those that begin in it
    for (std::size_t i = 0; i < as_size(D); ++i)
      cells.upper[i] = std::min(core.upper[i] + 1, field_.shape.dims[i]);
    const FieldStats here = scan(cells, box, samples, threads);
    stats_.n_removed_cells += here.n_removed_cells;
    if (here.n_holes > 0) stats_.n_holes += count_holes(core, box, samples);
    if (here.n_holes == n_points<D>(cells.upper - cells.lower)) return;
    stats_.min = is_empty_ ? here.min : std::min(stats_.min, here.min);
    stats_.max = is_empty_ ? here.max : std::max(stats_.max, here.max);
    is_empty_ = false;
  }
  [[nodiscard]] const FieldStats& stats() const { return stats_; }

 private:
  /// Calls body(the row's first sample, how many) for rows of a box inside of another.
  template <typename Body>
  void for_each_row_of(const LatticeBox<D>& inner, const LatticeBox<D>& box,
                       const std::byte* samples, const Body& body) const {
    Index<D> rows = inner.upper - inner.lower;
    const std::size_t n = as_size(std::exchange(rows[0], 1));
    for (std::size_t i = 0; i < n_points<D>(rows); ++i) {
      const Index<D> p = inner.lower + point_of<D>(rows, i) - box.lower;
      body(samples + linear_index<D>(box.upper - box.lower, p) * field_.sample_size(), n);
    }
  }
  FieldStats scan(const LatticeBox<D>& cells, const LatticeBox<D>& box, const std::byte* samples,
                  Threads threads) {
    constexpr std::size_t kBytes = std::size_t{4} << 20;
    const std::size_t last = as_size(D - 1);
    VolumeInfo info = field_.info;
    for (std::size_t i = 0; i < as_size(D); ++i)
      info.grid.dims[as_size(field_.axes.axis[i])] = cells.upper[i] - cells.lower[i];
    FieldScan<D> scan(info);
    LatticeBox<D> slab = cells;
    slab.upper[last] = slab.lower[last] + 1;
    const std::size_t slice = n_points<D>(slab.upper - slab.lower) * field_.sample_size();
    const auto n_slices = static_cast<std::int32_t>(std::max<std::size_t>(1, kBytes / slice));
    for (; slab.lower[last] < cells.upper[last]; slab.lower[last] = slab.upper[last]) {
      slab.upper[last] =
          slab.lower[last] + std::min(n_slices, cells.upper[last] - slab.lower[last]);
      slab_.clear();
      for_each_row_of(slab, box, samples, [&](const std::byte* row, std::size_t n) {
        slab_.insert(slab_.end(), row, row + n * field_.sample_size());
      });
      scan.put(slab.lower[last] - cells.lower[last], slab.upper[last] - cells.lower[last],
               slab_.data(), threads);
    }
    return scan.stats();
  }
  [[nodiscard]] std::uint64_t count_holes(const LatticeBox<D>& core, const LatticeBox<D>& box,
                                          const std::byte* samples) const {
    std::uint64_t n_holes = 0;
    visit_storage_type(field_.storage, [&]<typename T>() {
      for_each_row_of(core, box, samples, [&](const std::byte* row, std::size_t n) {
        const T* values = reinterpret_cast<const T*>(row);
        for (std::size_t i = 0; i < n; ++i)
          n_holes += field_.is_hole(static_cast<double>(values[i])) ? 1 : 0;
      });
    });
    return n_holes;
  }

  const CoarseField<D>& field_;
  FieldStats stats_;
  bool is_empty_ = true;
  std::vector<std::byte> slab_;
};

template <int D>
class RebuildCheck {
 public:
  RebuildCheck(const store::Reader& reader, const Metadata& metadata, std::int32_t chunks_per_part,
               std::uint64_t cache_bytes, Threads threads, Progress& progress)
      : file_{reader, shape_of<D>(metadata.info.grid.dims), has_worlds(reader)},
        said_(metadata.summary),
        chunks_per_part_(chunks_per_part),
        threads_(threads),
        progress_(progress),
        field_(CoarseField<D>::make(metadata.info, true)),
        blocks_(reader, cache_bytes),
        samples_(field_, blocks_, threads),
        builder_(field_, threads),
        stats_(field_) {
    field_.stats = metadata.summary.stats;
  }

  Result<BlockFindings> run() {
    LODE_CHECK(load_coarse_samples<D>(file_.reader, threads_, field_));
    builder_.reserve(PartPlan<D>::largest(field_.shape, chunks_per_part_).dims);
    const Index<D> n = chunk_counts<D>(field_.shape);
    for (std::size_t done = 0; done < n_points<D>(n);) {
      LatticeBox<D> chunks{chunk_at<D>(field_.shape, done), {}};
      chunks.upper = chunks.lower + all_equal<D>(1);
      chunks.upper[0] = std::min(chunks.lower[0] + chunks_per_part_, n[0]);
      LODE_CHECK(check_part(PartPlan<D>::of(field_.shape, chunks)));
      done += as_size(chunks.upper[0] - chunks.lower[0]);
      progress_.report("verifying",
                       static_cast<double>(done) / static_cast<double>(n_points<D>(n)));
    }
    LODE_CHECK(check_stats(file_.reader, said_.stats, stats_.stats()));
    LODE_CHECK(check_coarse());
    LODE_CHECK(check_errors(file_.reader, said_, summarize<D>(field_, builder_)));
    LODE_CHECK(check_number_of_blocks());
    return std::move(findings_);
  }

 private:
  Result<void> check_part(const PartPlan<D>& plan) {
    builder_.begin(plan);
    const LatticeBox<D> core = samples_of_chunks<D>(field_.shape, plan.chunks);
    const LatticeBox<D> missing = builder_.missing_samples();
    // What the part before has left the builder is looked at here, too.
    LatticeBox<D> box = missing;
    std::int32_t& lowest = box.lower[kLastAxis<D>];
    lowest = std::min(lowest, core.lower[kLastAxis<D>]);
    box_.resize(n_points<D>(box.upper - box.lower) * field_.sample_size());
    LODE_CHECK(samples_.read(box, progress_, {box_.data(), box_.size()}));
    stats_.add(core, box, box_.data(), threads_);
    LatticeBox<D> before = box;
    before.upper[kLastAxis<D>] = missing.lower[kLastAxis<D>];
    if (n_points<D>(missing.upper - missing.lower) > 0)
      builder_.put_samples(
          missing, box_.data() + n_points<D>(before.upper - before.lower) * field_.sample_size());
    field_.put_samples(box, box_.data());
    LODE_CHECK(builder_.find_attributes(progress_, [] {}));
    Index<D> chunk = plan.chunks.lower;
    for (; chunk[0] < plan.chunks.upper[0]; ++chunk[0])
      LODE_CHECK(compare(builder_.model(), builder_.model().worlds, plan.part.origin,
                         chunk_blocks<D>(field_.shape, chunk)));
    return {};
  }
  Result<void> check_coarse() {
    if (!field_.is_needed()) return {};
    nest_coarse<D>(field_, threads_);
    return compare(field_, field_.worlds, Index<D>{}, coarse_blocks<D>(field_.shape));
  }
  template <typename Field>
  Result<void> compare(const Field& field, const WorldErrors& worlds, const Index<D>& origin,
                       const std::vector<BlockGroup<D>>& groups) {
    return compare_groups<D>(file_, field, worlds, origin, std::span(groups), threads_, progress_,
                             findings_);
  }
  Result<void> check_number_of_blocks() const {
    std::uint64_t n = 0;
    for (const store::BlockEntry& block : file_.reader.blocks())
      n += is_of_model(block.key) ? 1 : 0;
    if (n == findings_.n_blocks) return {};
    return fail("{}: expected {} blocks, as its field has, got {}", file_.reader.path(),
                findings_.n_blocks, n);
  }

  ComparedFile<D> file_;
  Summary said_;
  std::int32_t chunks_per_part_;
  Threads threads_;
  Progress& progress_;
  CoarseField<D> field_;
  store::BlockCache blocks_;
  FileSamples<D> samples_;
  PartBuilder<D> builder_;
  PartStats<D> stats_;
  UninitializedArray<std::byte> box_;
  BlockFindings findings_;
};

/// Bytes of samples that parts one after the other have in common, at most: rows of chunks along
/// the last axis, the next beside them.
template <int D>
std::uint64_t shared_bytes(const VolumeInfo& info) {
  const Shape<D> shape = shape_of<D>(info.grid.dims);
  std::uint64_t n = size_of(storage_type(info.type));
  for (std::size_t i = 0; i < as_size(D); ++i)
    n *= as_size(i == 0 || i == kLastAxis<D> ? shape.dims[i]
                                             : std::min(shape.dims[i], 2 * kChunkEdge<D>));
  return n;
}

}  // namespace

template <int D>
std::uint64_t least_rebuild_bytes(const VolumeInfo& info) {
  return rebuild_bytes<D>(info, 1, 1);
}

template <int D>
Result<BlockFindings> rebuild_check(const store::Reader& reader, const RebuildSettings& settings,
                                    Progress& progress) {
  LODE_TRY(const Metadata metadata, read_metadata(reader));
  LODE_CHECK(check_current(reader, metadata));
  const VolumeInfo& info = metadata.info;
  std::int32_t chunks = chunk_counts<D>(shape_of<D>(info.grid.dims))[0];
  int n_threads = n_workers(settings.threads);
  std::uint64_t cache = shared_bytes<D>(info);
  if (const std::uint64_t limit = settings.memory_limit; limit > 0) {
    const auto bytes = [&] { return rebuild_bytes<D>(info, chunks, n_threads); };
    while (chunks > 1 && bytes() > limit) --chunks;
    while (n_threads > 1 && bytes() > limit) --n_threads;
    // Blocks that are kept lie between others that are not.
    cache = std::min(cache, (limit - std::min(limit, bytes())) / 4 * 3);
  }
  return RebuildCheck<D>(reader, metadata, chunks, cache, {n_threads}, progress).run();
}

template std::uint64_t least_rebuild_bytes<2>(const VolumeInfo&);
template std::uint64_t least_rebuild_bytes<3>(const VolumeInfo&);
template Result<BlockFindings> rebuild_check<2>(const store::Reader&, const RebuildSettings&,
                                                Progress&);
template Result<BlockFindings> rebuild_check<3>(const store::Reader&, const RebuildSettings&,
                                                Progress&);

}  // namespace lode::diamond
