#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/models/diamond/cell_field.h"

namespace lode::diamond {

/// Whether triangles in the border planes may be caps, inside which the field is only bounded
/// from below.
enum class Caps : std::uint8_t { none, on_border };

struct LevelSetOptions {
  std::vector<double> isovalues;   ///< At least one; of several, Surface::isovalues says which.
  double tolerance = 0;            ///< Largest |F - isovalue| allowed, slack included, field units.
  std::optional<Box3d> clip = {};  ///< The surface must stay inside; its planes may have caps.
  Caps caps = Caps::none;
  double cap_tolerance = 0;  ///< How much more isovalue - F may be on these.
  /// Where there are some: only what lies in one of them is looked at.
  std::span<const Box3d> boxes = {};
  Threads threads = {};
};

/// Triangles (lines) that break one rule: how many, and the lowest index.
struct SimplexOffenders {
  std::uint64_t count = 0;
  std::uint32_t first = 0;

  friend bool operator==(const SimplexOffenders&, const SimplexOffenders&) = default;
};

struct LevelSetReport {
  std::uint64_t n_simplices = 0;
  std::uint64_t n_pieces = 0;  ///< Parts the finest simplices cut them into.
  std::uint64_t n_caps = 0;    ///< Simplices taken for caps.
  double max_deviation = 0;    ///< Largest |F - isovalue|; on caps, isovalue - F.
  std::uint32_t worst_simplex = 0;
  Vec3d worst_point{{0, 0, 0}};  ///< Where, in world coordinates.
  SimplexOffenders beyond_tolerance;
  SimplexOffenders outside;             ///< Of the lattice or the clip box.
  SimplexOffenders inside_removed;      ///< Within cells that holes remove.
  SimplexOffenders ambiguous_isovalue;  ///< Corners with different isovalues.
  Vec3d index_rounding{{0, 0, 0}};      ///< Distances up to this, in index units, are rounding.

  [[nodiscard]] bool holds() const {
    return beyond_tolerance.count == 0 && outside.count == 0 && inside_removed.count == 0 &&
           ambiguous_isovalue.count == 0;
  }
};

/// Checks |F - isovalue| <= tolerance everywhere on a well-formed surface, F being the
/// full-resolution field: each triangle is cut by the finest simplices, on which F is linear, and F
/// evaluated at the corners of the pieces. A deviation counts as beyond the tolerance only if it is
/// so by more than the rounding of this evaluation. A triangle may run along the border of a
/// removed cell, not through it. Fails when cancelled.
[[nodiscard]] Result<LevelSetReport> check_level_set(const FieldSamples& samples,
                                                     const Surface& surface,
                                                     const LevelSetOptions& options,
                                                     Progress& progress);

}  // namespace lode::diamond
