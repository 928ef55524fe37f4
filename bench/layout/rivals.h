#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/box.h"
#include "lode/core/volume.h"

namespace lode::bench {

/// Blocks (pages, slabs, bricks) and bytes that a reader touches.
struct Touched {
  std::uint64_t blocks = 0;
  std::uint64_t bytes = 0;
};

/// Which samples of a volume a query needs.
class SampleSet {
 public:
  explicit SampleSet(const Index3& dims);

  void add(const Index3& p) { is_in_[index_of(p)] = true; }
  [[nodiscard]] const std::vector<bool>& is_in() const { return is_in_; }
  [[nodiscard]] const Index3& dims() const { return dims_; }
  [[nodiscard]] std::size_t index_of(const Index3& p) const;

 private:
  Index3 dims_;
  std::vector<bool> is_in_;
};

/// All corners of the cells of `box` that an isosurface crosses, at full resolution.
[[nodiscard]] SampleSet crossed_cells(const Volume& volume, double isovalue, const IndexBox& box);

/// A volume in plain bricks of edge^3 samples (less at the ends), each compressed by zstd, level 3.
class PlainBricks {
 public:
  PlainBricks(const Volume& volume, std::int32_t edge);

  [[nodiscard]] Touched touched(const SampleSet& samples) const;
  [[nodiscard]] std::uint64_t n_bytes() const;

 private:
  std::int32_t edge_;
  Index3 counts_;
  std::vector<std::uint64_t> sizes_;
};

/// Pages of 4 KiB of the raw samples, x fastest, that hold one of them.
[[nodiscard]] Touched touched_pages(const SampleSet& samples, std::size_t sample_size);
/// Slabs of one sample along z that hold one of them.
[[nodiscard]] Touched touched_slabs(const SampleSet& samples, std::size_t sample_size);

}  // namespace lode::bench
