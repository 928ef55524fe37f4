#pragma once

#include <vector>

#include "lode/core/progress.h"
#include "lode/models/diamond/persist.h"
#include "lode/models/diamond/salvage_blocks.h"

namespace lode::diamond {

/// What the blocks of a damaged file that are whole say of its nodes: true of the field as it was,
/// also where it is lost. A node whose own block is lost has what all its parents have in common,
/// as their ranges and errors cover its own; nodes without parents have the metadata's.
template <int D>
class KnownNodes {
 public:
  struct Facts {
    double low = 0;  ///< F is between them where it has a value; low > high: it has none.
    double high = 0;
    double error = 0;  ///< Largest |F - F'| where F' is the mean of the ends of a node's axis.

    void narrow(const Facts& other) {
      low = std::max(low, other.low);
      high = std::min(high, other.high);
      error = std::min(error, other.error);
    }
  };

  /// Blocks that are damaged, or that contradict the metadata, are appended to `lost`. Fails on
  /// cancel only.
  [[nodiscard]] static Result<KnownNodes> load(const store::Reader& reader,
                                               const Metadata& metadata, Threads threads,
                                               Progress& progress,
                                               std::vector<LostRegion<D>>& lost);

  /// Of the field at a sample of the data; the error is that of the node there.
  [[nodiscard]] Facts at(const Index<D>& sample) const;

 private:
  /// Only what the metadata say: no samples are here.
  struct Field : LatticeField<D, Field> {};

  explicit KnownNodes(const Metadata& metadata);
  [[nodiscard]] Result<void> load_errors(const store::Reader& reader, Threads threads,
                                         Progress& progress, std::vector<LostRegion<D>>& lost);
  template <typename R>
  [[nodiscard]] Result<void> load_ranges(const store::Reader& reader, Threads threads,
                                         Progress& progress, std::vector<LostRegion<D>>& lost);
  void complete(std::span<const LostRegion<D>> lost, Threads threads);
  void complete(const Diamond<D>& node, std::size_t at);

  [[nodiscard]] bool is_in_grid(const Index<D>& p, int level) const;
  [[nodiscard]] Facts of_field(int level) const;
  [[nodiscard]] Facts of_parents(const Diamond<D>& node) const;
  [[nodiscard]] Facts of_node(const Diamond<D>& node) const;

  Field field_;
  std::vector<double> max_errors_;  ///< By level.
  std::vector<NodeLevel> levels_;   ///< On the levels' grids; [0] is empty.
};

extern template class KnownNodes<2>;
extern template class KnownNodes<3>;

}  // namespace lode::diamond
