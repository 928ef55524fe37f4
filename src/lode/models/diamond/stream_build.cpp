#include "lode/models/diamond/stream_build.h"

#include <atomic>
#include <future>
#include <optional>
#include <system_error>
#include <utility>

#include "lode/core/stopwatch.h"
#include "lode/models/diamond/build.h"
#include "lode/models/diamond/coarse_nesting.h"
#include "lode/models/diamond/encode_blocks.h"
#include "lode/models/diamond/field_scan.h"
#include "lode/models/diamond/part_log.h"
#include "lode/models/diamond/part_reads.h"
#include "lode/store/bytes.h"
#include "lode/store/checksum.h"

namespace lode::diamond {
namespace {

/// Counts up with every change of what a build writes, so that none goes on from another's part.
constexpr std::uint32_t kPartFormat = 8;

/// Lets a source obey `progress` for as long as this is there.
class Obedience {
 public:
  Obedience(VolumeSource& source, const Progress& progress) : source_(source) {
    source_.obey(&progress);
  }
  Obedience(const Obedience&) = delete;
  Obedience& operator=(const Obedience&) = delete;
  ~Obedience() { source_.obey(nullptr); }

 private:
  VolumeSource& source_;
};

/// Hands out boxes of a source's samples in their storage type, a few slices at a time.
template <int D>
class BoxReader {
 public:
  static constexpr std::size_t kBytesPerRead = std::size_t{4} << 20;  // stays in a cache

  BoxReader(VolumeSource& source, Threads threads)
      : source_(source),
        axes_(AxisMap<D>::of(source.info().grid.dims)),
        unit_(source.read_unit().dims[as_size(axes_.axis[as_size(D - 1)])]),
        reading_(n_workers(threads) > 1 ? std::launch::async : std::launch::deferred) {}

  /// Calls put(box, values) for slabs of the box along its last axis, in ascending order. While it
  /// runs the next slab is read.
  template <typename Put>
  Result<void> read(const LatticeBox<D>& box, const Progress& progress, const Put& put) {
    if (box.lower[as_size(D - 1)] == box.upper[as_size(D - 1)]) return {};
    const VolumeInfo& info = source_.info();
    const std::size_t size = size_of(info.type);
    LatticeBox<D> slab = box;
    std::int32_t& begin = slab.lower[as_size(D - 1)];
    std::int32_t& end = slab.upper[as_size(D - 1)];
    end = begin + 1;
    const std::size_t slice = n_points<D>(slab.upper - slab.lower);
    const auto n_slices =
        static_cast<std::int32_t>(std::max<std::size_t>(1, kBytesPerRead / (slice * size)));
    const auto start_reading = [&](std::vector<std::byte>& into) {
      end = slab_end(begin, n_slices, box.upper[as_size(D - 1)]);
      into.resize(slice * as_size(end - begin) * size);
      const auto read = [this, &into, grid = grid_box<D>(axes_, slab)] {
        return source_.read(grid, into);
      };
      try {
        return std::async(reading_, read);
      } catch (const std::system_error&) {  // no thread is left: then when it is waited for
        return std::async(std::launch::deferred, read);
      }
    };
    auto next = start_reading(next_);
    while (begin < box.upper[as_size(D - 1)]) {
      LODE_CHECK(next.get());
      if (progress.is_cancelled()) return cancelled_error();
      std::swap(bytes_, next_);
      n_bytes_ += bytes_.size();
      const LatticeBox<D> here = slab;
      begin = end;
      if (begin < box.upper[as_size(D - 1)]) next = start_reading(next_);
      put(here, widened(info.type));
    }
    return {};
  }
  [[nodiscard]] std::uint64_t n_bytes() const { return n_bytes_; }

 private:
  /// The slab in its storage type.
  std::span<const std::byte> widened(ScalarType type) {
    if (storage_type(type) == type) return bytes_;
    const std::size_t n = bytes_.size() / size_of(type);
    wide_.resize(n * size_of(storage_type(type)));
    widen_samples(type, bytes_.data(), n, wide_.data());
    return wide_;
  }
  /// A slab that ends inside of units would need those before and behind at once.
  [[nodiscard]] std::int32_t slab_end(std::int32_t begin, std::int32_t n_slices,
                                      std::int32_t last) const {
    const std::int32_t end = n_slices < last - begin ? begin + n_slices : last;
    const std::int32_t whole_units = end - end % unit_;
    return end < last && whole_units > begin ? whole_units : end;
  }

  VolumeSource& source_;
  AxisMap<D> axes_;
  std::int32_t unit_;  ///< Of the source, along the last axis.
  std::launch reading_;
  std::vector<std::byte> bytes_;  ///< A slab,
  std::vector<std::byte> next_;   ///< the next,
  std::vector<std::byte> wide_;   ///< and the slab in its storage type.
  std::uint64_t n_bytes_ = 0;
};

/// Bytes that a build with so many chunks a part takes at most. has_units: whether the source reads
/// more than single samples as a whole.
template <int D>
std::uint64_t build_bytes(const VolumeInfo& info, bool has_units, std::int32_t chunks_per_part,
                          Threads threads) {
  constexpr std::uint64_t kCompressing = std::uint64_t{32} << 20;
  const Shape<D> shape = shape_of<D>(info.grid.dims);
  const std::size_t size = size_of(info.type);
  const std::size_t wide_size = size_of(storage_type(info.type));
  const std::uint64_t largest = PartPlan<D>::largest(shape, chunks_per_part).n_bytes(wide_size);
  std::uint64_t slice = 2 * size + (wide_size == size ? 0 : wide_size) + 1;  // and where holes are
  std::uint64_t n_reads = 4;
  if (has_units) {  // may come in pieces: io/border_spool.h
    slice += size;
    ++n_reads;
  }
  for (std::size_t i = 0; i + 1 < as_size(D); ++i)
    slice *= static_cast<std::uint64_t>(shape.dims[i]);
  const std::uint64_t reading =
      std::max<std::uint64_t>(slice, n_reads * BoxReader<D>::kBytesPerRead);
  // For each thread points of bricks by parity (world_block.h), and samples of cubes side by side.
  const std::uint64_t scratch = as_size(n_workers(threads)) * (std::uint64_t{2} << 20);
  return largest + CoarseField<D>::n_bytes(info, true) + reading + kCompressing + scratch;
}

/// As many chunks a part as the memory holds.
template <int D>
Result<std::int32_t> choose_chunks(const VolumeSource& source, const StreamSettings& settings) {
  const VolumeInfo& info = source.info();
  const std::int32_t n = chunk_counts<D>(shape_of<D>(info.grid.dims))[0];
  if (settings.chunks_per_part > 0) return std::min(settings.chunks_per_part, n);
  if (settings.memory_limit == 0) return n;
  const bool has_units = source.read_unit().dims != Index3{{1, 1, 1}};
  const std::uint64_t held = source.memory_bytes();
  for (std::int32_t chunks = n; chunks > 0; --chunks)
    if (held + build_bytes<D>(info, has_units, chunks, settings.threads) <= settings.memory_limit)
      return chunks;
  // What a source holds grows with the limit, to a quarter of it.
  const std::uint64_t least = build_bytes<D>(info, has_units, 1, settings.threads);
  const std::uint64_t needed = std::max(held + least, held > 0 ? least / 3 * 4 + 4 : 0);
  return fail("expected a memory limit of at least {} MB for {} samples of {} bytes, got {} MB",
              needed / 1'000'000 + 1, info.grid.n_samples(), size_of(info.type),
              settings.memory_limit / 1'000'000);
}

template <int D>
class StreamBuild {
 public:
  /// `spool`: the source, where that keeps border layers; else null.
  StreamBuild(VolumeSource& source, io::BorderSpool* spool, const StreamSettings& settings,
              std::int32_t chunks_per_part, Progress& progress)
      : source_(source),
        spool_(spool),
        settings_(settings),
        chunks_per_part_(chunks_per_part),
        progress_(progress),
        reader_(source, settings.threads),
        field_(CoarseField<D>::make(source.info(), true)),
        builder_(field_, settings.threads) {}

  Result<StreamReport> run(const std::string& path) {
    LODE_CHECK(scan());
    LODE_TRY(auto writer, open(path));
    report_.n_chunks_resumed = done_.n_chunks;
    builder_.reserve(PartPlan<D>::largest(field_.shape, chunks_per_part_).dims);
    while (done_.n_chunks < n_points<D>(chunk_dims())) LODE_CHECK(build_next_part(writer));
    LODE_CHECK(finish_coarse(writer));
    report_.metadata = {field_.info, summarize<D>(field_, builder_)};
    report_.bytes_read = reader_.n_bytes();
    report_.io = source_.io();
    writer.set_metadata(encode_metadata(report_.metadata));
    LODE_TRY(report_.file_bytes, writer.finish(progress_));
    if (log_) log_->remove();
    log_.reset();
    PartLog<D>::remove_leftovers(path);
    return std::move(report_);
  }

 private:
  [[nodiscard]] Index<D> chunk_dims() const { return chunk_counts<D>(field_.shape); }

  void add_to_checksum(std::span<const std::byte> values) {
    if (settings_.unfinished == Unfinished::nothing) return;
    const std::array<std::uint64_t, 2> sums{samples_checksum_, store::checksum(values)};
    samples_checksum_ = store::checksum(std::as_bytes(std::span(sums)));
  }

  [[nodiscard]] std::uint64_t n_sample_bytes() const {
    return n_points<D>(field_.shape.dims) * field_.sample_size();
  }

  Result<void> scan() {
    const Stopwatch watch;
    FieldScan<D> scan(field_.info);
    const std::int32_t n = field_.shape.dims[as_size(D - 1)];
    LODE_CHECK(reader_.read({{}, field_.shape.dims}, progress_,
                            [&](const LatticeBox<D>& box, std::span<const std::byte> values) {
                              const std::int32_t begin = box.lower[as_size(D - 1)];
                              const std::int32_t end = box.upper[as_size(D - 1)];
                              scan.put(begin, end, values.data(), settings_.threads);
                              field_.put_samples(box, values.data());
                              add_to_checksum(values);
                              progress_.report("reading", static_cast<double>(end) / n,
                                               n_sample_bytes());
                            }));
    field_.stats = scan.stats();
    report_.scan_seconds = watch.seconds();
    return check_magnitude(field_.stats);
  }

  /// The file, with what an earlier build has done.
  Result<store::Writer> open(const std::string& path) {
    LODE_TRY(auto writer, open_writer(path));
    if (field_.has_holes()) writer.require(store::kFeatureRemovedCells);
    if (!field_.info.units.is_empty()) writer.require(store::kFeatureUnits);
    writer.set_early_metadata(encode_early_metadata(field_.info, field_.stats));
    return writer;
  }

  Result<store::Writer> open_writer(const std::string& path) {
    const bool is_one_part = n_points<D>(chunk_dims()) <= as_size(chunks_per_part_);
    if (settings_.unfinished == Unfinished::nothing || is_one_part)
      return store::Writer::create(path, model_name<D>(), {});
    if (settings_.has_part != nullptr) *settings_.has_part = true;
    store::ByteWriter head;
    head.write(kPartFormat);
    head.write_string(model_name<D>());
    head.write_bytes(encode_metadata({field_.info, {field_.stats, 0, {}}}));
    head.write(samples_checksum_);
    if (settings_.unfinished == Unfinished::resume) {
      LODE_TRY(auto log, PartLog<D>::resume(path, head.bytes(), field_, done_));
      log_.emplace(std::move(log));
      if (done_.n_chunks > 0) builder_.set_largest_errors(done_.largest_errors);
    } else {
      LODE_TRY(auto log, PartLog<D>::create(path, head.bytes()));
      log_.emplace(std::move(log));
    }
    return store::Writer::open_part(path, model_name<D>(), done_.blocks, progress_);
  }

  /// The chunks from the next one on, in its row.
  Result<void> build_next_part(store::Writer& writer) {
    const Index<D> n = chunk_dims();
    LatticeBox<D> chunks{chunk_at<D>(field_.shape, done_.n_chunks), {}};
    chunks.upper = chunks.lower + all_equal<D>(1);
    // One that was resumed ends where it would have without that.
    const std::int32_t end = (chunks.lower[0] / chunks_per_part_ + 1) * chunks_per_part_;
    chunks.upper[0] = std::min(end, n[0]);
    const PartPlan<D> plan = PartPlan<D>::of(field_.shape, chunks);
    LODE_CHECK(build_part(plan, writer));
    done_.n_chunks += as_size(chunks.upper[0] - chunks.lower[0]);
    if (log_) {
      LODE_CHECK(writer.sync());
      const auto blocks = writer.blocks().subspan(done_.blocks.size());
      done_.blocks.insert(done_.blocks.end(), blocks.begin(), blocks.end());
      done_.largest_errors = builder_.largest_errors();
      LODE_CHECK(log_->add(plan, field_, done_));
    }
    return {};
  }

  Result<void> build_part(const PartPlan<D>& plan, store::Writer& writer) {
    Stopwatch watch;
    builder_.begin(plan);
    if (spool_ != nullptr) spool_->begin_part(grid_box<D>(field_.axes, plan.samples));
    LODE_CHECK(reader_.read(builder_.missing_samples(), progress_,
                            [&](const LatticeBox<D>& box, std::span<const std::byte> values) {
                              builder_.put_samples(box, values.data());
                            }));
    report_.read_seconds += watch.seconds();
    watch = Stopwatch();
    // A small field is one part: how far that is shows what is left.
    const auto n_bricks = static_cast<double>(builder_.n_bricks());
    const auto n_chunks = static_cast<double>(n_points<D>(chunk_dims()));
    const double share = static_cast<double>(n_points<D>(plan.chunks.upper - plan.chunks.lower));
    std::atomic<std::size_t> n_bricks_done{0};
    LODE_CHECK(builder_.find_attributes(progress_, [&] {
      const double part = static_cast<double>(++n_bricks_done) / n_bricks;
      progress_.report("building", (static_cast<double>(done_.n_chunks) + share * part) / n_chunks,
                       n_sample_bytes());
    }));
    report_.build_seconds += watch.seconds();
    watch = Stopwatch();
    Index<D> chunk = plan.chunks.lower;
    for (; chunk[0] < plan.chunks.upper[0]; ++chunk[0])
      LODE_CHECK(builder_.append_chunk(chunk, writer, progress_));
    report_.write_seconds += watch.seconds();
    ++report_.n_parts;
    return {};
  }

  Result<void> finish_coarse(store::Writer& writer) {
    if (!field_.is_needed()) return {};
    const Stopwatch watch;
    nest_coarse<D>(field_, settings_.threads);
    const std::vector<BlockGroup<D>> groups = coarse_blocks<D>(field_.shape);
    LODE_CHECK(append_groups<D>(field_, field_.worlds, Index<D>{},
                                std::span<const BlockGroup<D>>(groups), writer, settings_.threads,
                                progress_));
    report_.write_seconds += watch.seconds();
    return {};
  }

  VolumeSource& source_;
  io::BorderSpool* spool_;
  StreamSettings settings_;
  std::int32_t chunks_per_part_;
  Progress& progress_;
  BoxReader<D> reader_;
  CoarseField<D> field_;
  PartBuilder<D> builder_;
  std::optional<PartLog<D>> log_;
  std::uint64_t samples_checksum_ = 0;  ///< Of slabs, chained.
  PartsDone done_;
  StreamReport report_;
};

}  // namespace

template <int D>
Result<StreamReport> build_file(VolumeSource& source, const std::string& path,
                                const StreamSettings& settings, Progress& progress) {
  LODE_CHECK(check_axes(source.info()));
  LODE_TRY(const std::int32_t chunks_per_part, choose_chunks<D>(source, settings));
  LODE_TRY(const auto spool, spool_borders<D>(source, chunks_per_part, path));
  VolumeSource& from = spool ? *spool : source;
  const Obedience obedience(from, progress);
  return StreamBuild<D>(from, spool.get(), settings, chunks_per_part, progress).run(path);
}

template Result<StreamReport> build_file<2>(VolumeSource&, const std::string&,
                                            const StreamSettings&, Progress&);
template Result<StreamReport> build_file<3>(VolumeSource&, const std::string&,
                                            const StreamSettings&, Progress&);

}  // namespace lode::diamond
