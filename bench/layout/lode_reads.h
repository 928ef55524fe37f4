#pragma once

#include <string>

#include "bench/layout/rivals.h"
#include "lode/api/dataset.h"
#include "lode/core/result.h"

namespace lode::bench {

/// What extracting an isosurface reads of a closed .lode file, each block once.
[[nodiscard]] Result<Touched> read_for_surface(const std::string& path, double isovalue,
                                               double tolerance);

/// What refining it in a box alone reads, from the base.
[[nodiscard]] Result<Touched> read_for_box(const std::string& path, double isovalue,
                                           double tolerance, const Box3d& box);

/// What refining it from the base to so many simplices reads.
[[nodiscard]] Result<Touched> read_for_overview(const std::string& path, double isovalue,
                                                std::uint64_t n_cells);

/// The samples at the corners of the crossed simplices of an overview.
[[nodiscard]] Result<SampleSet> corners_of_overview(const std::string& path, double isovalue,
                                                    std::uint64_t n_cells);

/// The samples at the corners of the simplices that read_for_surface()'s answer comes from.
[[nodiscard]] Result<SampleSet> corners_of_cut(const std::string& path, double isovalue,
                                               double tolerance);

/// Sizes and speed of a file, against its samples.
struct FileFacts {
  std::uint64_t n_blocks = 0;
  std::uint64_t data_bytes = 0;       ///< Blocks of samples,
  std::uint64_t attribute_bytes = 0;  ///< of errors and ranges,
  std::uint64_t other_bytes = 0;      ///< header and directory.
  double write_rate = 0;  ///< Raw bytes of all blocks that are gathered, encoded and written, and
  double read_rate = 0;   ///< read, checked and decoded in a second of one processor.
};

/// Writes the dataset to a file and says what it is. The fastest of three runs.
[[nodiscard]] Result<FileFacts> write_file(const Dataset& dataset, const std::string& path);

}  // namespace lode::bench
