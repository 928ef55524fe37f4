#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "lode/api/dataset.h"
#include "lode/api/salvage.h"
#include "lode/models/diamond/file_parts.h"
#include "lode/models/diamond/paged_model.h"
#include "lode/models/diamond/persist.h"
#include "lode/models/diamond/world_error.h"

namespace lode {

/// What a Dataset holds: one of the built-in models, in memory or in a file. Const members are safe
/// from many threads.
class Dataset::Impl {
 public:
  using AnyModel = std::variant<diamond::Model<2>, diamond::Model<3>>;
  using AnyPages = std::variant<std::unique_ptr<const diamond::PagedModel<2>>,
                                std::unique_ptr<const diamond::PagedModel<3>>>;

  explicit Impl(AnyModel built, std::optional<SalvageReport> salvaged = {});
  Impl(store::Reader reader, diamond::Metadata metadata, Threads threads);

  [[nodiscard]] bool is_flat() const { return is_flat_; }
  [[nodiscard]] const VolumeInfo& info() const { return metadata_.info; }
  [[nodiscard]] const diamond::Summary& summary() const { return metadata_.summary; }
  /// Of the file; none for a model that was built.
  [[nodiscard]] const std::optional<diamond::StoredBytes>& stored() const { return stored_; }

  /// Of the file; empty for a model that was built.
  [[nodiscard]] std::string path() const { return reader_ ? reader_->path() : std::string(); }
  /// Of the file so far.
  [[nodiscard]] store::ReadCounts reads() const {
    return reader_ ? reader_->reads() : store::ReadCounts();
  }
  /// Of a file that is not whole.
  [[nodiscard]] const std::optional<SalvageReport>& salvaged() const { return salvaged_; }

  /// All of it in memory; a file is loaded when this is first asked.
  [[nodiscard]] Result<const AnyModel*> model(Progress& progress) const;
  /// Pages of the file that come when they are wanted; null if the model is in memory.
  /// The coarsest are read when this is first asked.
  [[nodiscard]] Result<const AnyPages*> pages(Progress& progress) const;
  /// The coarse levels of a file that extraction goes through chunk by chunk, and blocks of it that
  /// were used last; null where it takes the model in memory: that is there already, or
  /// small.
  struct Chunks {
    std::variant<diamond::CoarseField<2>, diamond::CoarseField<3>> field;
    store::BlockCache blocks;
  };
  /// `beside_model`: where that does not matter.
  [[nodiscard]] Result<Chunks*> chunks(std::uint64_t memory_limit, bool beside_model) const;
  [[nodiscard]] bool has_file() const { return reader_.has_value(); }
  /// Whether model() would have to load it.
  [[nodiscard]] bool is_in_file() const { return !is_in_memory_; }
  /// About what model() takes.
  [[nodiscard]] std::uint64_t model_bytes() const;
  /// What model() takes, and so many bytes for each triangle of these isosurfaces at full
  /// resolution. To count those it loads the model of a file, and keeps it where all of that is
  /// within the limit.
  [[nodiscard]] Result<std::uint64_t> bytes_with_triangles(std::span<const double> isovalues,
                                                           double bytes_per_triangle,
                                                           std::uint64_t limit,
                                                           Progress& progress) const;
  /// The least limit that extracting chunk by chunk keeps, the surface aside.
  [[nodiscard]] std::uint64_t chunk_bytes() const;
  /// Of the model in memory: found when first asked for, on all cores.
  [[nodiscard]] Result<std::shared_ptr<const diamond::WorldErrors>> world_errors(
      Progress& progress) const;

 private:
  /// Triangles of isosurfaces at full resolution, together.
  struct Counted {
    std::vector<double> isovalues;
    std::uint64_t n = 0;
  };
  [[nodiscard]] Result<AnyModel> load(Progress& progress) const;

  bool is_flat_;
  diamond::Metadata metadata_;
  std::optional<diamond::StoredBytes> stored_;
  std::optional<SalvageReport> salvaged_;
  Threads threads_{};
  std::optional<store::Reader> reader_;
  mutable std::mutex mutex_;
  mutable std::optional<AnyModel> model_;
  mutable Counted counted_;  ///< When this was last asked for.
  mutable std::atomic<bool> is_in_memory_{false};
  mutable std::mutex pages_mutex_;
  mutable std::optional<AnyPages> pages_;
  mutable std::mutex chunks_mutex_;
  mutable std::unique_ptr<Chunks> chunks_;
  mutable std::mutex world_errors_mutex_;
  mutable std::shared_ptr<const diamond::WorldErrors> world_errors_;
};

/// Refuses options that have no answer.
[[nodiscard]] Result<void> check_extract_options(const ExtractOptions& options);
/// With what the data cannot have.
[[nodiscard]] Result<void> check_extraction(const Dataset::Impl& impl,
                                            const ExtractOptions& options);

/// The tolerance that is chosen where none is asked for.
[[nodiscard]] inline double default_tolerance(const diamond::FieldStats& stats) {
  constexpr double kShareOfRange = 0.005;
  return kShareOfRange * (stats.max - stats.min);
}

[[nodiscard]] inline double tolerance_of(const diamond::FieldStats& stats,
                                         const ExtractOptions& options) {
  if (options.max_distance && !options.max_error) return std::numeric_limits<double>::infinity();
  return options.max_error.value_or(default_tolerance(stats));
}

}  // namespace lode
