#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/models/diamond/cell_field.h"
#include "lode/models/diamond/surface_coordinates.h"

namespace lode::diamond {

struct BoundaryOptions {
  std::optional<Box3d> clip = {};  ///< World planes the surface may end in.
  /// World units; where there are some, only edges that are wholly in one of them are looked at.
  std::span<const Box3d> boxes = {};
  /// Of a simplified surface, which goes along the planes that it ends in: any plane of the lattice
  /// where there are holes.
  bool goes_along_planes = false;
  Threads threads = {};
};

/// Where a surface ends. An edge in several places counts at the first of them.
struct BoundaryReport {
  std::uint64_t n_edges = 0;      ///< Edges of one triangle; for contour lines, end points.
  std::uint64_t n_on_border = 0;  ///< In a border plane of the lattice.
  std::uint64_t n_on_clip = 0;    ///< In a plane of the clip box.
  std::uint64_t n_on_holes = 0;   ///< Between present and removed cells.
  std::uint64_t n_stray = 0;      ///< Anywhere else: the surface has a gap.
  std::array<std::uint32_t, 2> first_stray{{0, 0}};  ///< Its vertices, in the triangle's direction.

  [[nodiscard]] bool holds() const { return n_stray == 0; }
};

/// Checks that a well-formed surface ends only where its domain does, within coordinate rounding.
/// Fails when cancelled.
[[nodiscard]] Result<BoundaryReport> check_boundary(const FieldSamples& samples,
                                                    const Surface& surface,
                                                    const BoundaryOptions& options,
                                                    Progress& progress);

/// Whether a surface's domain may be pinched at a vertex of it, which lies between present and
/// removed cells, or in a plane of the clip box. Within coordinate rounding.
class PinchPlaces {
 public:
  /// `samples` must outlive it.
  PinchPlaces(const FieldSamples& samples, const Surface& surface, const BoundaryOptions& options)
      : samples_(samples), coordinates_(samples.grid(), surface, options.clip, options.threads) {}

  [[nodiscard]] bool contain(std::uint32_t vertex) const;

 private:
  const FieldSamples& samples_;
  SurfaceCoordinates coordinates_;
};

}  // namespace lode::diamond
