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
    if (storage_type(type) != type) {
      wide_.resize(n * size_of(storage_type(type)));
      widen_samples(type, read_.data(), n, wide_.data());
    }
    const std::vector<std::byte>& theirs = storage_type(type) == type ? read_ : wide_;
    visit_storage_type(field_.storage, [&]<typename S>() {
      visit_storage_type(storage_type(type), [&]<typename T>() {
        compare(box, reinterpret_cast<const S*>(stored_.data()),
                reinterpret_cast<const T*>(theirs.data()), n);
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
  std::vector<std::byte> stored_, read_, wide_;
  AttributeFinding finding_;
};

/// What is looked at at once, and what is kept of blocks.
template <int D>
struct ComparisonPlan {
  Index<D> edges = all_equal<D>(kChunkEdge<D>);  ///< Samples.
  std::uint64_t cache_bytes = 0;

  /// Blocks that are being decoded, and what an allocator keeps.
  static constexpr std::uint64_t kRest = std::uint64_t{24} << 20;
  static constexpr std::int32_t kLeastEdge = 16;

  /// Both sides in their storage types, and theirs as they are read.
  [[nodiscard]] std::uint64_t box_bytes(const VolumeInfo& info, ScalarType original) const {
    return n_points<D>(edges) *
           (size_of(storage_type(info.type)) + size_of(storage_type(original)) + size_of(original));
  }
  /// Rows of chunks, or less of them, in a half of what the coarse field leaves of a limit; the
  /// other half is for blocks.
  [[nodiscard]] static ComparisonPlan of(const VolumeInfo& info, ScalarType original,
                                         std::uint64_t limit) {
    ComparisonPlan plan;
    const Shape<D> shape = shape_of<D>(info.grid.dims);
    plan.edges[0] = shape.dims[0];
    const std::uint64_t coarse = CoarseField<D>::n_bytes(info) + kRest;
    const std::uint64_t left = limit - std::min(limit, coarse);
    for (std::size_t i = 0; i < as_size(D); ++i)
      plan.edges[i] = std::min(plan.edges[i], shape.dims[i]);
    // The last axes first: what is read together stays together.
    for (std::size_t i = as_size(D); i-- > 0;)
      while (plan.edges[i] > kLeastEdge && plan.box_bytes(info, original) > left / 2)
        plan.edges[i] = std::max(kLeastEdge, plan.edges[i] / 2);
    plan.cache_bytes = left / 8 * 3;
    return plan;
  }
};

}  // namespace

template <int D>
std::uint64_t least_comparison_bytes(const VolumeInfo& info, ScalarType original) {
  ComparisonPlan<D> least;
  least.edges = all_equal<D>(ComparisonPlan<D>::kLeastEdge);
  return CoarseField<D>::n_bytes(info) + ComparisonPlan<D>::kRest +
         2 * least.box_bytes(info, original);
}

template <int D>
Result<AttributeFinding> compare_samples(const store::Reader& reader, VolumeSource& original,
                                         const RebuildSettings& settings, Progress& progress) {
  LODE_TRY(const Metadata metadata, read_metadata(reader));
  LODE_EXPECTS(original.info().grid.dims == metadata.info.grid.dims);
  auto field = CoarseField<D>::make(metadata.info);
  field.stats = metadata.summary.stats;
  LODE_CHECK(load_coarse_samples<D>(reader, settings.threads, field));
  constexpr std::uint64_t kMuch = std::uint64_t{1} << 32;
  const auto plan =
      ComparisonPlan<D>::of(metadata.info, original.info().type,
                            settings.memory_limit > 0 ? settings.memory_limit : kMuch);
  store::BlockCache blocks(reader, plan.cache_bytes);
  const FileSamples<D> ours(field, blocks, settings.threads);
  SampleComparison<D> comparison(field, ours, original);
  Index<D> n;
  for (std::size_t i = 0; i < as_size(D); ++i)
    n[i] = (field.shape.dims[i] + plan.edges[i] - 1) / plan.edges[i];
  for (std::size_t i = 0; i < n_points<D>(n); ++i) {
    if (progress.is_cancelled()) return cancelled_error();
    LatticeBox<D> box{point_of<D>(n, i), {}};
    for (std::size_t a = 0; a < as_size(D); ++a) {
      box.lower[a] *= plan.edges[a];
      box.upper[a] = std::min(box.lower[a] + plan.edges[a], field.shape.dims[a]);
    }
    LODE_CHECK(comparison.run(box, progress));
    progress.report("comparing samples",
                    static_cast<double>(i + 1) / static_cast<double>(n_points<D>(n)));
  }
  return comparison.finding();
}

template std::uint64_t least_comparison_bytes<2>(const VolumeInfo&, ScalarType);
template std::uint64_t least_comparison_bytes<3>(const VolumeInfo&, ScalarType);
template Result<AttributeFinding> compare_samples<2>(const store::Reader&, VolumeSource&,
                                                     const RebuildSettings&, Progress&);
template Result<AttributeFinding> compare_samples<3>(const store::Reader&, VolumeSource&,
                                                     const RebuildSettings&, Progress&);

}  // namespace lode::diamond
