#include "lode/models/diamond/sample_check.h"

#include <fmt/ranges.h>

#include "lode/models/diamond/file_samples.h"
#include "lode/models/diamond/part_reads.h"

namespace lode::diamond {
namespace {

/// Both sides of a box.
template <int D>
class SampleComparison {
 public:
  SampleComparison(const CoarseField<D>& field, const FileSamples<D>& ours, VolumeSource& original)
      : field_(field), ours_(ours), original_(original) {}

  Result<void> run(const LatticeBox<D>& box, const Progress& progress) {
    const std::size_t n = n_points<D>(box.upper - box.lower);
    const ScalarType type = original_.info().type;
    stored_.resize(n * field_.sample_size());
    read_.resize(n * size_of(type));
    LODE_CHECK(ours_.read(box, progress, stored_));
    LODE_CHECK(original_.read(grid_box<D>(field_.axes, box), read_));
    theirs_.resize(n * size_of(storage_type(type)));
    widen_samples(type, read_.data(), n, theirs_.data());
    visit_storage_type(field_.storage, [&]<typename S>() {
      visit_storage_type(storage_type(type), [&]<typename T>() {
        compare(box, reinterpret_cast<const S*>(stored_.data()),
                reinterpret_cast<const T*>(theirs_.data()), n);
      });
    });
    return {};
  }
  [[nodiscard]] const AttributeFinding& finding() const { return finding_; }

 private:
  template <typename S, typename T>
  void compare(const LatticeBox<D>& box, const S* stored, const T* original, std::size_t n) {
    finding_.n_checked += n;
    for (std::size_t i = 0; i < n; ++i) {
      const auto ours = static_cast<double>(stored[i]);
      const auto theirs = static_cast<double>(original[i]);
      if (ours == theirs || (!std::isfinite(ours) && !std::isfinite(theirs))) continue;
      if (finding_.n_wrong++ > 0) continue;
      const Index<D> p = box.lower + point_of<D>(box.upper - box.lower, i);
      finding_.worst = fmt::format("first: {} instead of {} at sample {}", ours, theirs,
                                   fmt::join(field_.axes.to_grid(p).v, " "));
    }
  }

  const CoarseField<D>& field_;
  const FileSamples<D>& ours_;
  VolumeSource& original_;
  std::vector<std::byte> stored_, read_, theirs_;
  AttributeFinding finding_;
};

}  // namespace

template <int D>
Result<AttributeFinding> compare_samples(const store::Reader& reader, VolumeSource& original,
                                         const RebuildSettings& settings, Progress& progress) {
  LODE_TRY(const Metadata metadata, read_metadata(reader));
  auto field = CoarseField<D>::make(metadata.info);
  LODE_EXPECTS(original.info().grid.dims == metadata.info.grid.dims);
  field.stats = metadata.summary.stats;
  LODE_CHECK(load_coarse_samples<D>(reader, settings.threads, field));
  store::BlockCache blocks(reader, std::uint64_t{64} << 20);
  const FileSamples<D> ours(field, blocks, settings.threads);
  SampleComparison<D> comparison(field, ours, original);
  // Rows of chunks, as many of these as memory holds: both sides, and theirs as they are read.
  const Index<D> n = chunk_counts<D>(field.shape);
  std::uint64_t chunk = 24;
  for (std::size_t i = 0; i < as_size(D); ++i)
    chunk *= as_size(std::min(kChunkEdge<D>, field.shape.dims[i]));
  const std::uint64_t most = std::max<std::uint64_t>(1, settings.memory_limit / 2 / chunk);
  const auto step =
      static_cast<std::int32_t>(std::min<std::uint64_t>(most, static_cast<std::uint64_t>(n[0])));
  for (std::size_t done = 0; done < n_points<D>(n);) {
    LatticeBox<D> chunks{point_of<D>(n, done), {}};
    chunks.upper = chunks.lower + all_equal<D>(1);
    chunks.upper[0] = std::min(chunks.lower[0] + step, n[0]);
    LODE_CHECK(comparison.run(samples_of_chunks<D>(field.shape, chunks), progress));
    if (progress.is_cancelled()) return cancelled_error();
    done += as_size(chunks.upper[0] - chunks.lower[0]);
    progress.report("comparing samples",
                    static_cast<double>(done) / static_cast<double>(n_points<D>(n)));
  }
  return comparison.finding();
}

template Result<AttributeFinding> compare_samples<2>(const store::Reader&, VolumeSource&,
                                                     const RebuildSettings&, Progress&);
template Result<AttributeFinding> compare_samples<3>(const store::Reader&, VolumeSource&,
                                                     const RebuildSettings&, Progress&);

}  // namespace lode::diamond
