#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "lode/api/terrain_selection.h"
#include "lode/api/terrain_source.h"
#include "lode/locate/tin_height.h"
#include "lode/models/terrain/quadtree_file/quadtree_file.h"
#include "lode/models/terrain/squares/cell_walk.h"

namespace lode {

/// The leaves of a surface quadtree, bilinear, or of a quaternary triangulation, linear. A place on
/// sides of leaves has the height of the smallest (TerrainPatches), so vertices of the mesh have
/// their samples': a sample that is a corner of any leaf is one of the smallest that holds it.
class QuadtreePatches final : public TerrainPatches {
 public:
  /// Of what select() made of the model, with its leaves in their order; these are errors of
  /// leaves, or of triangles. The model, of one of the two kinds, outlives it. With samples in the
  /// options errors hold everywhere. Fails when cancelled.
  [[nodiscard]] static Result<QuadtreePatches> make(const quadtree_file::QuadtreeModel& model,
                                                    SelectedTerrain selected,
                                                    const TerrainOptions& options,
                                                    Progress& progress);

  [[nodiscard]] const TerrainReport& report() const override { return report_; }
  [[nodiscard]] LatticePoint lower() const override { return lower_; }
  [[nodiscard]] LatticePoint upper() const override { return upper_; }
  [[nodiscard]] std::optional<Height> height_at(const delaunay::Point& at) const override;
  [[nodiscard]] std::vector<ProfilePoint> profile(const delaunay::Point& a,
                                                  const delaunay::Point& b) const override;

 private:
  struct Leaf {
    squares::Square square;
    bool is_upper = false;  ///< Of a triangle.
    float error = 0;
  };

  explicit QuadtreePatches(const quadtree_file::QuadtreeModel& model);
  [[nodiscard]] bool is_bilinear() const;
  void add_leaves(const delaunay::Tin& tin);
  void fill_index();
  /// The number of the leaf that has a place or side where some halves of cells meet, or nothing.
  [[nodiscard]] std::optional<std::uint32_t> leaf_of(const squares::CellHalves& halves) const;
  /// In the index.
  [[nodiscard]] std::size_t place_of(const squares::CellHalf& half) const;
  [[nodiscard]] TinHeight height_in(const Leaf& leaf, const delaunay::Point& at) const;
  void add_piece(const Leaf& leaf, double begin, double end, const delaunay::Point& a,
                 const delaunay::Point& b, bool goes_on, std::vector<ProfilePoint>& points) const;

  const quadtree_file::QuadtreeModel* model_;
  squares::CellGrid grid_;
  TerrainReport report_;
  LatticePoint lower_{};
  LatticePoint upper_{};
  double least_bend_ = 0;  ///< Chords may be that far from what bends.
  std::vector<Leaf> leaves_;
  /// Per cell, or per half of one, lower then upper: a leaf, or none.
  std::vector<std::uint32_t> index_;
};

}  // namespace lode
