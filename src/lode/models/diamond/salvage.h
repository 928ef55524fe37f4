#pragma once

#include <string>
#include <vector>

#include "lode/models/diamond/persist.h"

namespace lode::diamond {

/// A block of a damaged file that could not be used.
struct LostBlock {
  store::BlockKey key;
  std::string reason;
  std::uint64_t n_samples = 0;  ///< Of the data that are lost with it.
  std::uint64_t n_holes = 0;    ///< Of them, filled with holes.
  IndexBox box;                 ///< They lie in it; in the grid's indices.
  double max_error = 0;  ///< Proven bound of |F - filled| at those that have a value in both.
};

struct SalvageReport {
  std::uint64_t n_blocks = 0;  ///< Of the model, when the file was whole.
  std::vector<LostBlock> lost;
  std::uint64_t n_samples = 0;  ///< Sums of the lost blocks'; the largest error.
  std::uint64_t n_holes = 0;
  double max_error = 0;
  std::uint64_t n_lost_holes = 0;  ///< How many of the samples that are lost were holes.
};

template <int D>
struct Salvaged {
  Model<D> model;
  SalvageReport report;
};

/// Loads a model of which some blocks are damaged, missing, as at the end of a file that was cut
/// off, or contradict the metadata. Lost samples are filled, coarse levels first: with the mean of
/// the ends of their node's axis, or the middle of their range where neither is there, clamped to
/// the range that whole nodes say they have. All attributes are then found anew, so all that is
/// true of a model is true of this one, whose field is the filled one. Where samples are lost but
/// no holes are, or only holes, it has holes just where the original has; else what holes were lost
/// can only be guessed.
///
/// Fails where the metadata are wrong, where no block is lost but they disagree with it, and on
/// cancel. Takes the memory of load() and 5 to 6 bytes a sample while it fills.
template <int D>
[[nodiscard]] Result<Salvaged<D>> salvage(const store::Reader& reader, Threads threads,
                                          Progress& progress);

}  // namespace lode::diamond
