#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/mappers/collapse_distance.h"
#include "lode/mappers/collapse_mesh.h"
#include "lode/mappers/collapse_undo.h"
#include "lode/mappers/simplify_surface.h"

namespace lode::simplification {

/// Proves what collapses made of a surface, triangle by triangle: that it meets itself nowhere new,
/// is near, and in the band, as far as the options ask.
class CollapseProof {
 public:
  /// `edge`: about the longest of original triangles. `first`: of the collapses since all was
  /// proven.
  CollapseProof(const Surface& original, const CollapseMesh& mesh, const CollapseUndo& stars,
                const SimplifyOptions& options, double edge, std::uint32_t first,
                Progress& progress)
      : original_(original),
        mesh_(mesh),
        stars_(stars),
        options_(options),
        first_(first),
        progress_(progress),
        distance_(original, mesh, stars, options.max_distance, edge, progress) {}

  /// Collapses whose triangles fail, last first. `live`: all triangles that are there, ascending;
  /// `changed`: those that were not proven as they are.
  [[nodiscard]] Result<std::vector<std::uint32_t>> find_bad(std::span<const std::uint32_t> live,
                                                            std::span<const std::uint32_t> changed);

  [[nodiscard]] double proven_distance() const { return proven_distance_; }
  [[nodiscard]] double proven_error() const { return proven_error_; }
  [[nodiscard]] bool meets_itself_already() const { return meets_itself_already_; }

 private:
  [[nodiscard]] std::vector<std::uint32_t> to_recheck(std::span<const std::uint32_t> live,
                                                      std::span<const std::uint32_t> changed);
  [[nodiscard]] bool is_changed(std::uint32_t triangle) const;
  /// Of a triangle that is there.
  enum class Nearness : std::uint8_t { none, beside, changed };
  [[nodiscard]] std::vector<std::uint32_t> original_of_few(std::span<const std::uint32_t> near,
                                                           std::span<const Nearness> nearness);
  [[nodiscard]] std::vector<std::uint32_t> original_of_many(
      std::span<const Nearness> nearness) const;
  [[nodiscard]] bool concerns(std::uint32_t triangle, Nearness nearness) const;
  void find_far(std::span<const std::uint32_t> made, std::span<const std::uint32_t> to_prove_near,
                std::vector<std::uint32_t>& bad);
  void find_beyond(std::span<const std::uint32_t> made, std::vector<std::uint32_t>& bad);

  const Surface& original_;
  const CollapseMesh& mesh_;
  const CollapseUndo& stars_;
  const SimplifyOptions& options_;
  std::uint32_t first_;
  Progress& progress_;
  DistanceProof distance_;
  bool has_begun_ = false;
  std::vector<std::uint32_t> far_;  ///< Original triangles that were not proven near the last time.
  double proven_distance_ = 0;
  double proven_error_ = 0;
  bool meets_itself_already_ = false;
};

}  // namespace lode::simplification
