#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lode/core/box.h"

namespace lode {

/// A block of a .lode file that could not be used, and what was lost with it.
struct LostBlock {
  std::string kind;  ///< "samples", "errors", "minima" or "maxima".
  int level = 0;
  Index3 position;     ///< As docs/format.md numbers blocks.
  std::string reason;  ///< With the file's name.
  std::uint64_t n_samples = 0;
  /// World units: outside of it the block's loss changes nothing. None where no sample is lost.
  std::optional<Box3d> box;
  double max_error = 0;  ///< See SalvageReport.
};

/// The lost blocks of one level, together.
struct LostLevel {
  int level = 0;
  std::uint64_t n_blocks = 0;
  std::uint64_t n_samples = 0;
  double max_error = 0;
};

/// What Dataset::salvage() found damaged and how it filled what is lost: each lost sample with the
/// mean of two coarser ones, the ends of the edge that it bisects. Attributes are found anew, so
/// that of the filled field everything is as proven as ever. Of the original field F holds what
/// follows from |F - filled| <= max_error, in field units: an answer that is within E of the filled
/// field is within E + max_error of F, and within E outside the boxes. That is a proof, from ranges
/// and errors that whole blocks and the metadata say of F, wherever both fields have a value.
struct SalvageReport {
  std::uint64_t n_blocks = 0;     ///< Of the file when it was whole, without indexes.
  std::vector<LostBlock> blocks;  ///< That are lost.
  std::vector<LostLevel> levels;  ///< Those with lost blocks, finest first.
  std::uint64_t n_samples = 0;    ///< That are lost. 0: all is as it was.
  double max_error = 0;           ///< The largest of the blocks'.
  std::optional<Box3d> box;       ///< Round all of theirs.
  /// How many of the lost samples were holes, and how many were filled as such. Where the first is
  /// 0, or all that are lost, no cell is missing and none is too many; else which were is a guess.
  std::uint64_t n_lost_holes = 0;
  std::uint64_t n_filled_holes = 0;
};

/// Whether a file says enough of its blocks for Dataset::salvage() to try: its directory is whole,
/// or an index of blocks.
[[nodiscard]] bool can_salvage(const std::string& path);

}  // namespace lode
