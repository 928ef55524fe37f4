#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>

#include "lode/core/box.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/models/diamond/cell_field.h"

namespace lode::diamond {

/// Where a surface's triangles are counter-clockwise seen from.
enum class SeenFrom : std::uint8_t { lower_values, higher_values, either };

struct SideOptions {
  double isovalue = 0;
  double error = 0;  ///< Samples farther than this from the isovalue are asked about,
  Index3 reach{};    ///< and all others up to so many steps away along each axis alike;
  /// or, of their places in the world, it says so. Safe from many threads.
  std::function<bool(const Vec3d&)> is_far{};
  SeenFrom seen_from = SeenFrom::lower_values;  ///< either: all of it one way.
  bool has_holes = true;                        ///< Whether cells may be removed.
  std::span<const Box3d> boxes = {};  ///< Where there are some: only pairs in one of them.
  Threads threads = {};
};

struct SideReport {
  std::uint64_t n_pairs = 0;  ///< Neighbours among such samples, in rows along the axes.
  std::uint64_t n_wrong = 0;
  std::array<Index3, 2> first{};                ///< The first wrong pair, where there is one.
  SeenFrom seen_from = SeenFrom::lower_values;  ///< What was held of all; of either the better one.
};

/// Whether a surface of triangles lies between the samples above the isovalue and those below, and
/// faces these: of each two in a row of the grid, without another or a removed cell between, the
/// surface must be crossed from higher to lower values as often as from lower to higher ones, or
/// once more or less where they are on both sides, by rays beside the row. Fails when cancelled.
[[nodiscard]] Result<SideReport> check_sides(const FieldSamples& samples, const Surface& surface,
                                             const SideOptions& options, Progress& progress);

}  // namespace lode::diamond
