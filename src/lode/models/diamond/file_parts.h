#pragma once

#include <span>
#include <vector>

#include "lode/models/diamond/flat_field.h"
#include "lode/models/diamond/leaf_attributes.h"
#include "lode/models/diamond/part_builder.h"
#include "lode/models/diamond/persist.h"
#include "lode/store/block_cache.h"

namespace lode::diamond {

/// Reads levels kKeptLevel and coarser of a file: n / 512 of its n samples, and their nodes. Fails
/// on blocks that are missing or damaged, hold what no node has, or holes where the metadata know
/// of none, and where the errors are not those of the metadata.
template <int D>
[[nodiscard]] Result<CoarseField<D>> load_coarse(const store::Reader& reader,
                                                 const Metadata& metadata, Threads threads);

/// A chunk of a file's field, with what extracting from some of its bricks takes.
template <int D>
class FilePart {
 public:
  /// Samples that normals at a brick's vertices need beyond it, from blocks of levels up to
  /// kChunkLevel.
  static constexpr std::int32_t kMargin = 1 << kChunkLevel;

  /// What one takes of memory, at most.
  [[nodiscard]] static std::uint64_t n_bytes(const VolumeInfo& info);

  FilePart(const CoarseField<D>& field, store::BlockCache& blocks, Threads threads)
      : field_(field), blocks_(blocks), threads_(threads) {}

  /// `fine`: bricks, numbered as those of the whole field, whose samples and nodes of all levels
  /// are wanted; `coarse`: those of which levels from kKeptLevel on are enough.
  [[nodiscard]] Result<void> load(const Index<D>& chunk, std::span<const Index<D>> fine,
                                  std::span<const Index<D>> coarse);

  /// Only samples() of these bricks, and what fine() and origin() say.
  [[nodiscard]] Result<void> load_samples(const Index<D>& chunk, std::span<const Index<D>> fine);

  /// What load() with these fine bricks will read is asked for; returns at once. What is loaded
  /// stays.
  void will_load(const Index<D>& chunk, std::span<const Index<D>> fine) const;

  /// Puts into model() what there is of bricks beside those that were wanted fine.
  void fill_beside();

  /// Of its bricks those that were wanted are there.
  [[nodiscard]] const Model<D>& model() const { return model_; }
  /// Samples of the bricks that were wanted fine, and kMargin round them; on model()'s lattice.
  [[nodiscard]] const FlatField<D>& samples() const { return flat_; }
  /// The bricks that were wanted fine, numbered as those of model().
  [[nodiscard]] std::span<const Index<D>> fine() const { return fine_; }
  /// Of the lattice in that of the field.
  [[nodiscard]] const Index<D>& origin() const { return plan_.part.origin; }

 private:
  /// Levels below `first_level` are not asked for.
  void begin(const Index<D>& chunk, int first_level);
  void set_fine(std::span<const Index<D>> bricks);
  /// Of the levels that are read chunk by chunk.
  [[nodiscard]] int coarsest_in_blocks() const {
    return std::min(kChunkLevel, field_.shape.n_levels - 1);
  }
  void take_coarse_samples();
  void take_coarse_nodes();
  [[nodiscard]] Result<void> read_samples(int level, std::span<const Index<D>> bricks);
  template <typename T, typename Put>
  [[nodiscard]] Result<void> read_kind(Kind kind, int level, std::span<const Index<D>> bricks,
                                       std::int32_t margin, const Put& put);
  /// The blocks that have points in one of the bricks, which lie in a box of samples, or `margin`
  /// samples round it.
  [[nodiscard]] std::vector<Region<D>> regions_near(Kind kind, int level,
                                                    const LatticeBox<D>& samples,
                                                    std::span<const Index<D>> bricks,
                                                    std::int32_t margin) const;
  [[nodiscard]] LatticeBox<D> samples_of(const PartPlan<D>& plan) const;
  [[nodiscard]] Result<void> read_attributes(int level, std::span<const Index<D>> bricks);
  [[nodiscard]] Index<D> to_local(const Index<D>& brick) const;
  void fill_brick(const Index<D>& local);
  void fill_coarse_brick(const Index<D>& local);
  /// By brick of model(): whether it is fine, or beside such a one.
  [[nodiscard]] std::vector<std::uint8_t> find_near_fine() const;
  void find_holes();
  template <typename C>
  void find_leaf_attributes(std::span<const Index<D>> bricks);
  template <typename C>
  void gather(const Index<D>& local, C* out) const;

  const CoarseField<D>& field_;
  store::BlockCache& blocks_;
  Threads threads_;
  PartPlan<D> plan_;
  FlatField<D> flat_;
  std::vector<Index<D>> fine_;
  Model<D> model_;
};

extern template class FilePart<2>;
extern template class FilePart<3>;

}  // namespace lode::diamond
