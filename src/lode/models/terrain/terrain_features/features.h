#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"

namespace lode::terrain_features {

enum class CriticalKind : std::uint8_t { pit, pass, peak };

struct CriticalPoint {
  std::uint32_t vertex = 0;
  CriticalKind kind = CriticalKind::pit;
  /// 1; of a pass how many of its pairs are kept, of those that it has: k where k + 1 ridges meet.
  std::uint32_t multiplicity = 1;
  /// The difference in height from what it is paired with, of a pass the largest; infinite where
  /// nothing is. Of a peak this is its prominence.
  double relief = 0;

  friend bool operator==(const CriticalPoint&, const CriticalPoint&) = default;
};

enum class LineKind : std::uint8_t { ridge, channel };

/// A separatrix, or a piece of one that ends where an earlier line goes on.
struct FeatureLine {
  LineKind kind = LineKind::ridge;
  std::vector<std::uint32_t> vertices;  ///< From a pass on; neighbours are ends of an edge.

  friend bool operator==(const FeatureLine&, const FeatureLine&) = default;
};

struct FeatureCounts {
  std::uint64_t peaks = 0;
  std::uint64_t passes = 0;  ///< Each as often as its multiplicity.
  std::uint64_t pits = 0;

  friend bool operator==(const FeatureCounts&, const FeatureCounts&) = default;
};

struct Features {
  std::vector<CriticalPoint> points;  ///< Kept ones, by vertex.
  /// Of kept passes, those of the largest relief first, ridges before channels.
  std::vector<FeatureLine> lines;
  FeatureCounts all;
  FeatureCounts kept;
  std::int64_t euler_number = 0;  ///< Of the TIN: vertices - edges + triangles.
};

/// The critical points of a TIN's surface, paired by persistence, and from each pass kept the
/// ridges up and the channels down to peaks and pits that are kept
/// (docs/models/terrain_features.md).
///
/// Heights are ordered by (height, vertex), so there are no ties, and what is outside of the domain
/// is lower than all of it: water leaves over the outline. For `all` as for `kept`, peaks - passes
/// + pits = euler_number.
///
/// Lines of one kind have no edge twice. They end at a kept peak or pit, on the outline (channels),
/// or where the rest of the way is another line's of their kind. At extrema that are not kept they
/// go on over the pass that these are paired over. Pairs are kept whose relief is at least
/// `least_relief`, which is >= 0.
///
/// The TIN has finite heights, and twins, as find_twins() has them; round a vertex the triangles
/// are in one closed fan, or in open ones. O(n log n) at most, of which all but sorting passes is
/// O(n). Memory: 16 bytes a vertex, and some 400 a pass with its lines. Fails when cancelled.
[[nodiscard]] Result<Features> find_features(const delaunay::Tin& tin, double least_relief,
                                             Progress& progress);

}  // namespace lode::terrain_features
