#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <variant>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/height_grid.h"
#include "lode/core/lattice_point.h"
#include "lode/core/parallel.h"
#include "lode/core/place_map.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"

namespace lode {

/// Heights at nodes of a lattice.
struct NodeHeights {
  HeightFrame frame;
  std::vector<LatticePoint> nodes;
  std::vector<double> heights;  ///< By node.
};

/// What a TIN is held against: a raster, corners of whose cells with four heights are samples, or
/// nodes.
using MeasuredSamples =
    std::variant<std::shared_ptr<const HeightGrid>, std::shared_ptr<const NodeHeights>>;

/// How far samples are from a TIN whose vertices are mapped, in the plane that they are mapped to:
/// its triangles have straight edges there, and samples, which are mapped too, lie elsewhere in
/// them than on the lattice, or in others.
struct MappedErrors {
  std::uint64_t n_samples = 0;  ///< In triangles.
  /// The largest |z - z'| of samples in the closed triangles that hold them, rounded up.
  double error = 0;
  Vec<double, 2> worst;  ///< The first sample that has it, before it is mapped.
  /// In triangles of the lattice, but in none of the plane, as chords of outlines bend.
  std::uint64_t n_without = 0;
};

/// A TIN with heights, and where its vertices are in the plane.
struct MappedTin {
  const delaunay::Tin& tin;
  const HeightFrame& frame;                ///< Of its lattice.
  std::span<const Vec<double, 2>> places;  ///< By vertex; triangles turn as in the world.
};

/// The lattice of the samples has the corners of the TIN's, which is as fine or whole times finer.
/// All samples between the first and last columns and rows of the TIN are mapped and sought in
/// squares of the plane, whatever triangle they were found in
/// before; decisions are exact, heights have 64 bits of mantissa. The same for any number of
/// threads. Fails where a sample in a triangle has no place in the plane, naming it, and when
/// cancelled. O(samples + triangles) where triangles are about alike.
[[nodiscard]] Result<MappedErrors> measure_mapped(const MappedTin& mapped, const PlaceMap& map,
                                                  const MeasuredSamples& samples, Threads threads,
                                                  Progress& progress);

/// Triangles as they turn left in the world.
[[nodiscard]] std::vector<std::array<std::uint32_t, 3>> turning_left_in_world(
    const delaunay::Tin& tin, const HeightFrame& frame);

}  // namespace lode
