#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "lode/api/tetra_cut_shape.h"
#include "lode/api/tetra_dataset.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/tetra_mt/midpoint/forest.h"
#include "lode/models/tetra_mt/structure_check.h"

namespace lode {

struct RefinedCells {
  TetraCells cells;
  double achieved = 0;           ///< Largest error of a node that is not applied,
  double achieved_world = 0;     ///< and world error, where the field has them.
  bool has_stated_world = true;  ///< Of the base: that is what the hierarchy states of it.
};

/// Cuts of a hierarchy of half edges or of midpoints, as verification looks at them. All fail where
/// pages cannot be loaded, or nodes do not fit together.
class TetraCutSource {
 public:
  TetraCutSource() = default;
  TetraCutSource(const TetraCutSource&) = delete;
  TetraCutSource& operator=(const TetraCutSource&) = delete;
  virtual ~TetraCutSource() = default;

  [[nodiscard]] const TetraInfo& info() const { return info_; }
  [[nodiscard]] virtual Result<tetra_mt::StructureFindings> check_structure(
      std::uint64_t seed, Progress& progress) const = 0;
  /// Of all cuts, without values.
  [[nodiscard]] virtual Result<TetraVertices> vertices() const = 0;
  [[nodiscard]] virtual Result<void> take_values(std::size_t field,
                                                 TetraVertices& vertices) const = 0;
  /// By vertex: makes true what a vertex that is came into.
  virtual void spread(std::vector<bool>& is) const = 0;
  /// Of a tolerance; none: the base.
  [[nodiscard]] virtual Result<RefinedCells> refined(std::size_t field,
                                                     std::optional<double> tolerance,
                                                     Progress& progress) const = 0;
  /// Of so many nodes at random, and what these need.
  [[nodiscard]] virtual Result<TetraCells> random(std::uint32_t n_nodes,
                                                  std::uint64_t seed) const = 0;
  /// Fills in what cells state of a field.
  [[nodiscard]] virtual Result<void> state(std::size_t field, TetraCells& cells) const = 0;

 protected:
  TetraInfo info_;
};

/// The hierarchy must outlive it.
[[nodiscard]] std::unique_ptr<const TetraCutSource> source_of(
    const tetra_mt::PackedHierarchy& hierarchy);
[[nodiscard]] std::unique_ptr<const TetraCutSource> source_of(
    const tetra_mt::midpoint::Forest& forest);

}  // namespace lode
