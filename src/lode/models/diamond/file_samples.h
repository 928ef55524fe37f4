#pragma once

#include "lode/core/progress.h"
#include "lode/models/diamond/block_order.h"
#include "lode/models/diamond/coarse_field.h"
#include "lode/store/block_cache.h"

namespace lode::diamond {

/// Fails where a block of samples has a hole though the metadata say there is none.
template <int D, typename Field>
[[nodiscard]] Result<void> check_no_holes(const LatticeField<D, Field>& field,
                                          const store::Reader& reader, const store::BlockKey& key,
                                          std::span<const std::byte> samples);

/// Reads samples of level kKeptLevel and coarser ones of a file into a field that was made for
/// them. Fails on blocks that are missing, damaged or of another size, and as check_no_holes().
template <int D>
[[nodiscard]] Result<void> load_coarse_samples(const store::Reader& reader, Threads threads,
                                               CoarseField<D>& field);

/// The samples of a file, box by box: those of finer levels from its blocks, the others from what a
/// field has kept.
template <int D>
class FileSamples {
 public:
  /// Both must outlive it.
  FileSamples(const CoarseField<D>& field, store::BlockCache& blocks, Threads threads)
      : field_(field), blocks_(blocks), threads_(threads) {}

  /// Those of a box inside the data, which is not empty, x fastest, in their storage type. Fails on
  /// blocks that are missing, damaged or of another size, and on cancel.
  [[nodiscard]] Result<void> read(const LatticeBox<D>& box, const Progress& progress,
                                  std::span<std::byte> out) const;

 private:
  [[nodiscard]] std::vector<Region<D>> regions_in(const LatticeBox<D>& box) const;
  void put_coarse(const LatticeBox<D>& box, std::byte* out) const;
  template <typename T>
  static void put_block(const Region<D>& r, const std::byte* from, const LatticeBox<D>& box,
                        std::byte* out);

  const CoarseField<D>& field_;
  store::BlockCache& blocks_;
  Threads threads_;
};

extern template class FileSamples<2>;
extern template class FileSamples<3>;

}  // namespace lode::diamond
