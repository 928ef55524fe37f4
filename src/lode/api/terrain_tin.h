#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lode/api/terrain.h"
#include "lode/core/horizontal_metric.h"

namespace lode {

/// A place in the world, x and y.
using Place = Vec<double, 2>;

/// The TIN's height at a place.
struct TerrainHeight {
  enum class Where : std::uint8_t { inside, gap, outside };

  Where where = Where::outside;  ///< gap: in the rectangle of the samples, but not in the domain.
  double height = 0;             ///< Where inside.
  /// Samples in the triangle are not farther from its plane, or everywhere
  /// (TerrainOptions::samples) full resolution, and rounding of the height.
  double bound = 0;
};

struct HeightsReport {
  std::uint64_t n_outside = 0;
  std::uint64_t n_in_gaps = 0;
  double prepare_seconds = 0;  ///< What making the locator took, the first time.
  double seconds = 0;
};

/// The profile along a segment.
struct TerrainProfile {
  struct Point {
    double distance = 0;  ///< From the start, as the metric has it.
    Place at;
    double height = 0;
    double bound = 0;        ///< As of TerrainHeight, of the triangles on both sides.
    std::uint32_t part = 0;  ///< From 1: there are gaps between parts.
  };
  struct Gap {
    double begin = 0;  ///< Distances.
    double end = 0;
  };

  std::vector<Point> points;
  std::vector<Gap> gaps;
  /// Where surfaces do not meet: two points at one place and distance.
  std::uint64_t n_steps = 0;
  double largest_step = 0;  ///< Of heights.
  double length = 0;        ///< Of the segment.
  double seconds = 0;
};

/// Contour lines in the world, higher ground on their left (x to the right, y up).
struct TerrainContours {
  struct Line {
    double height = 0;
    bool is_ring = false;
    std::vector<Place> points;  ///< Of a ring, the last is the first.
  };

  std::vector<Line> lines;  ///< From low to high.
  std::uint64_t n_rings = 0;
  std::uint64_t n_points = 0;
  std::uint64_t n_left_out = 0;  ///< Of one point: summits of just such a height.
  double seconds = 0;
};

/// What lies between neighbouring heights, as polygons in the world.
struct TerrainBands {
  struct Polygon {
    double lower = 0;  ///< Of the first and last band the lowest and highest height of the TIN.
    double upper = 0;
    std::vector<std::vector<Place>> rings;  ///< The outer one, turning left, then holes; closed.
  };

  std::vector<Polygon> polygons;  ///< From low to high.
  std::uint64_t n_holes = 0;
  std::uint64_t n_points = 0;
  double seconds = 0;
};

struct NeighboursOptions;
struct NeighboursReport;
struct TerrainNeighbours;
struct TerrainSight;
struct TerrainSightOptions;

/// What a TIN is asked for. places: heights(), profile() and sight() alone; of a model in a file
/// they then read what is near the places, where that is less, and find the same; of one whose
/// triangles leave gaps there is no use all, and its own surfaces are asked (TerrainPatches).
/// lines: contours() and height_range() alone; of a model in a file they then read what is near the
/// lines, where that is less, and trace the same. triangles: neighbours() and height_range() alone,
/// of any model.
enum class TinUse : std::uint8_t { all, places, lines, triangles };

/// A TIN of a terrain, to ask of. Const members are safe from many threads.
class TerrainTin {
 public:
  /// As extract_terrain(). Where the metric has an ellipsoid longitudes
  /// that differ by whole turns are one.
  [[nodiscard]] static Result<TerrainTin> select(const Terrain& terrain,
                                                 const TerrainOptions& options,
                                                 const HorizontalMetric& metric, Progress& progress,
                                                 TinUse use = TinUse::all);

  TerrainTin(TerrainTin&& other) noexcept;
  TerrainTin& operator=(TerrainTin&&) = delete;
  ~TerrainTin();

  /// Without slacks of coordinates.
  [[nodiscard]] const TerrainReport& report() const;

  /// Finite places; fills as many heights. Fails when cancelled.
  [[nodiscard]] Result<HeightsReport> heights(std::span<const Place> places,
                                              std::vector<TerrainHeight>& heights, Threads threads,
                                              Progress& progress) const;

  /// Of two places; fails where they are one, and as check_angles() does. A row for each edge or
  /// vertex that the segment, straight in the raster's coordinates, meets, and for its ends. Fails
  /// when cancelled.
  [[nodiscard]] Result<TerrainProfile> profile(const Place& from, const Place& to,
                                               Progress& progress) const;

  /// Of heights that rise strictly: see trace_contours() in mappers/tin_contours.h, whose rule for
  /// vertices at such a height holds. Fails when cancelled.
  [[nodiscard]] Result<TerrainContours> contours(std::span<const double> heights,
                                                 Progress& progress) const;

  /// The same of bands: see find_bands() in mappers/tin_bands.h.
  [[nodiscard]] Result<TerrainBands> bands(std::span<const double> heights,
                                           Progress& progress) const;

  /// Of finite places; fills as many answers. Triangles that meet edge to edge are neighbours, and
  /// where vertices hang in an edge all that have a part of it; so are those on both sides of a
  /// seam, where first and last column are one. Not of TinUse::places. Fails where answers have
  /// more triangles than the options allow, and when cancelled.
  [[nodiscard]] Result<NeighboursReport> neighbours(std::span<const Place> places,
                                                    const NeighboursOptions& options,
                                                    std::vector<TerrainNeighbours>& answers,
                                                    Progress& progress) const;

  /// See find_terrain_sight(): at this tolerance.
  [[nodiscard]] Result<TerrainSight> sight(const TerrainSightOptions& options,
                                           Progress& progress) const;

  /// Of its vertices. Not of TinUse::places.
  [[nodiscard]] HeightRange height_range() const;

  struct Impl;

 private:
  explicit TerrainTin(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace lode
