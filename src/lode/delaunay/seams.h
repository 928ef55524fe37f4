#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/delaunay/grid_cells.h"
#include "lode/delaunay/tile_layout.h"
#include "lode/delaunay/worst_sample.h"

namespace lode::delaunay {

/// The samples on one side of a tile that are vertices, of both tiles beside it: columns or rows of
/// the raster, from small to large. Where cells are, it begins and ends with them, and where the
/// cells on either side begin or end there is a vertex.
struct SeamSide {
  std::vector<std::int32_t> places;
  double error = 0;  ///< Samples between vertices err by no more.
};

/// Of all tiles; those of the raster's border, too.
class Seams {
 public:
  explicit Seams(const TileLayout& layout);

  [[nodiscard]] std::size_t n_sides() const { return sides_.size(); }
  /// The first and last node of a side.
  [[nodiscard]] LatticePart part(std::size_t side) const;
  [[nodiscard]] SeamSide& side(std::size_t number) { return sides_[number]; }

  [[nodiscard]] const SeamSide& below(std::size_t tile) const { return sides_[tile]; }
  [[nodiscard]] const SeamSide& above(std::size_t tile) const {
    return sides_[tile + layout_.n_across()];
  }
  [[nodiscard]] const SeamSide& left_of(std::size_t tile) const { return sides_[number(tile)]; }
  [[nodiscard]] const SeamSide& right_of(std::size_t tile) const {
    return sides_[number(tile) + 1];
  }

 private:
  /// Of the side to the left of a tile: those along rows come before.
  [[nodiscard]] std::size_t number(std::size_t tile) const {
    return n_along_rows_ + tile + tile / layout_.n_across();
  }

  TileLayout layout_;
  std::size_t n_along_rows_;
  std::vector<SeamSide> sides_;
};

/// What the samples of a raster ask for where tiles meet.
struct SeamOptions {
  double range = 0;  ///< Of the heights.
  double max_error = 0;
  Threads threads{};
  /// Of a raster whose last column is its first again (HeightFrame::is_round), that column's
  /// number: cells beside the one are beside the other, and both are split alike. Else 0.
  std::int32_t turn = 0;
};

/// Splits all sides of tiles until no sample on them errs by more than max_error. `cells`: null
/// where all are inside.
template <typename T>
[[nodiscard]] Seams find_seams(const TileLayout& layout, const SampleRows<T>& rows,
                               const GridCells* cells, const SeamOptions& options);

/// The same of a raster's first and last column alone, with a turn: the rows of the vertices of
/// both, but for those where neither has a cell.
template <typename T>
[[nodiscard]] std::vector<std::int32_t> find_round_side(LatticePoint last,
                                                        const SampleRows<T>& rows,
                                                        const GridCells* cells,
                                                        const SeamOptions& options);

/// How wide tiles should be: so many vertices on a side that seams cost little, as far as some
/// columns and rows of the raster tell. The same for any number of threads.
template <typename T>
[[nodiscard]] std::int32_t choose_tile_side(LatticePoint last, const SampleRows<T>& rows,
                                            const GridCells* cells, const SeamOptions& options);

}  // namespace lode::delaunay
