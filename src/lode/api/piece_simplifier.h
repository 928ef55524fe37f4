#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/regular_grid.h"
#include "lode/core/surface_sink.h"
#include "lode/mappers/simplify_surface.h"

namespace lode {

/// How a surface of full resolution comes in pieces, each in its own box of the grid's cells.
struct PieceShape {
  RegularGrid grid;               ///< Its axes are the world's: has_world_axes().
  std::size_t n_apart = 1;        ///< A piece has vertices in common with as many before it.
  std::size_t max_triangles = 1;  ///< Larger pieces are cut in boxes, down to single cells.
  bool drops_components = false;  ///< Those that a band lets go: drop_components_in_band().
};

/// Simplifies an isosurface's pieces on their way to a sink (simplify_piece()). In memory are one
/// piece, what simplifying takes for `max_triangles` of it, and the borders of `n_apart` pieces.
class PieceSimplifier : public SurfaceSink {
 public:
  PieceSimplifier(const SimplifyOptions& options, const PieceShape& shape, Progress& progress,
                  SurfaceSink& out)
      : options_(options), shape_(shape), progress_(progress), out_(out) {
    report_.max_distance = options.max_distance;
  }

  /// Of the pieces that follow.
  void set_band(const SurfaceBand* band) { options_.band = band; }
  [[nodiscard]] Result<void> add(SurfacePiece piece) override;
  void set_normals(std::span<const VertexNormal> normals) override { out_.set_normals(normals); }
  [[nodiscard]] std::uint32_t n_vertices() const override { return out_.n_vertices(); }
  /// Of all pieces so far.
  [[nodiscard]] const SimplifyReport& report() const { return report_; }

 private:
  using Triangles = std::vector<std::uint32_t>;
  /// A vertex that later pieces may have too: its number as they know it, and as the sink does.
  struct Shared {
    std::uint32_t before;
    std::uint32_t after;
  };

  [[nodiscard]] std::vector<Triangles> cut(const Surface& surface) const;
  [[nodiscard]] bool halve(const Surface& surface, Triangles& lower, Triangles& upper) const;
  [[nodiscard]] Result<void> add_part(const Surface& surface, const Triangles& triangles,
                                      std::vector<std::uint32_t>& numbers);
  [[nodiscard]] Result<std::vector<std::uint32_t>> drop_components(Surface& surface);
  [[nodiscard]] std::uint32_t number_of(std::uint32_t before) const;

  SimplifyOptions options_;
  PieceShape shape_;
  Progress& progress_;
  SurfaceSink& out_;
  SimplifyReport report_;
  std::deque<std::vector<Shared>> shared_;  ///< Of the last pieces, ascending.
  std::vector<std::uint32_t> local_;        ///< By vertex of a piece: its number in a part.
};

}  // namespace lode
