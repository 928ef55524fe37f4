#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"
#include "lode/models/terrain/delaunay_pyramid/encodings.h"
#include "lode/models/terrain/terrain_file/source.h"
#include "lode/models/terrain/terrain_file/stored_heights.h"

namespace lode::delaunay_pyramid {

/// How the levels of a Delaunay pyramid are kept: as CompletePyramid, or as TriangleLists without
/// and with links.
enum class Encoding : std::uint8_t { complete, lists, linked_lists };

[[nodiscard]] constexpr bool has_links(Encoding encoding) { return encoding != Encoding::lists; }

/// How many bytes parts of a pyramid take.
struct PyramidBytes {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;  ///< Corners, errors, and of lists deaths.
  std::uint64_t neighbours = 0;
  std::uint64_t links = 0;

  [[nodiscard]] std::uint64_t all() const { return vertices + triangles + neighbours + links; }
};

/// The mesh of a level.
struct MeshFacts {
  double largest_error = 0;   ///< That a triangle states.
  double smallest_angle = 0;  ///< Degrees, in the raster's coordinates.
  double median_angle = 0;    ///< Of smallest angles.
};

/// What is known of a pyramid before its vertices and triangles are. By level, which there is one
/// of at least.
struct PyramidHead {
  terrain_file::Source source;
  Encoding encoding = Encoding::complete;
  double max_error = 0;            ///< |z - z'| at every sample in the last level.
  std::vector<double> tolerances;  ///< Each finer than the one before.
  terrain_file::StoredHeight height_type = terrain_file::StoredHeight::float64;
  std::uint32_t n_lines = 0;
  std::vector<std::uint32_t> vertices_until;  ///< Those of its mesh; the first of all.
  std::vector<std::uint32_t> n_in_mesh;       ///< Triangles of its mesh.
  std::vector<std::uint32_t> n_kept;          ///< Triangles that are kept with it: all, or of lists
                                              ///< those that it makes.
  std::vector<std::uint64_t> n_links;         ///< Of these; of lists without links 0.

  std::vector<MeshFacts> facts;

  [[nodiscard]] std::size_t n_levels() const { return tolerances.size(); }
  [[nodiscard]] bool is_of_lists() const { return encoding != Encoding::complete; }
  [[nodiscard]] std::uint32_t first_vertex(std::size_t level) const {
    return level > 0 ? vertices_until[level - 1] : 0;
  }
  [[nodiscard]] std::uint64_t n_all_links() const;
  [[nodiscard]] std::uint64_t n_all_kept() const;
  /// No triangle of a level's mesh states more: its tolerance, rounded up as errors are.
  [[nodiscard]] float most_stated(std::size_t level) const;
  /// In memory, all of it.
  [[nodiscard]] PyramidBytes bytes() const;
};

/// What is kept with a level. Arrays are by triangle.
struct PyramidLevel {
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Vertices, turning left.
  std::vector<float> errors;                            ///< No sample in it errs by more.
  std::vector<std::array<std::uint32_t, 3>> twins;  ///< As LatticeTriangle::twin; of lists none.
  /// Of lists: the first level that has it no more, or the number of levels.
  std::vector<std::uint32_t> deaths;
  /// To triangles of the next level, or those kept with the level of its death, by their numbers
  /// there, ascending: those whose interiors meet its own.
  LinkLists links;
};

/// A Delaunay pyramid by levels, with the places and heights of its vertices. Of a file perhaps not
/// all levels: what was not read is empty.
struct Pyramid {
  PyramidHead head;
  std::vector<delaunay::LatticePoint> vertices;
  std::vector<double> heights;
  /// Edges of a coarser mesh, two vertices of level 0 each: edges of every level's, or chains.
  std::vector<std::array<std::uint32_t, 2>> lines;
  std::vector<PyramidLevel> levels;
};

/// The levels of a history at some tolerances, from its coarsest on and the last the finest it has,
/// which get finer. Fails when cancelled, and where links take more than the limit.
[[nodiscard]] Result<Pyramid> encode(const History& history, std::span<const double> tolerances,
                                     Encoding encoding, EncodingLimit limit, Progress& progress);

/// The triangles of a level's mesh by the pyramid's vertices, in the order of their making; with
/// errors.
[[nodiscard]] delaunay::Tin numbered_mesh(const Pyramid& pyramid, std::size_t level);

/// Of a mesh that numbered_mesh() gave.
[[nodiscard]] MeshFacts facts_of(const Pyramid& pyramid, const delaunay::Tin& mesh);

/// The mesh of a level, with heights, and what `links` says: that of the history at its time, with
/// triangles in the same order.
[[nodiscard]] delaunay::Tin tin_of_level(const Pyramid& pyramid, std::size_t level,
                                         delaunay::TinLinks links);

}  // namespace lode::delaunay_pyramid
