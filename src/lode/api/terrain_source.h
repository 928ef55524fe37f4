#pragma once

#include <memory>

#include "lode/core/height_frame.h"
#include "lode/core/height_grid.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"

namespace lode {

struct SelectedTerrain;
struct TerrainOptions;

/// What TINs are made of. Const members are safe from many threads.
class TerrainOrigin {
 public:
  virtual ~TerrainOrigin() = default;
  /// Of the lattice that the TINs' vertices are nodes of: of a raster its own, or a finer one.
  [[nodiscard]] virtual const HeightFrame& frame() const = 0;
  /// Of all heights that there are.
  [[nodiscard]] virtual HeightRange range() const = 0;
  /// The least tolerance that it keeps.
  [[nodiscard]] virtual double finest_error() const { return 0; }
  /// Whether it is all heights themselves, not a model of them.
  [[nodiscard]] virtual bool is_raster() const { return false; }
  /// A TIN with heights, with the tolerance and order that the options mean; with `links` also with
  /// twins and errors. Fails on options that it has no answer to, and when cancelled.
  [[nodiscard]] virtual Result<SelectedTerrain> select(const TerrainOptions& options,
                                                       delaunay::TinLinks links,
                                                       Progress& progress) const = 0;
  /// The TIN of all samples or points of the domain, with heights and twins, by the rule of
  /// to_full_tin() where it is of a raster. Fails where not all heights are at hand.
  [[nodiscard]] virtual Result<SelectedTerrain> select_all(Progress& progress) const;
};

/// A terrain to ask of: a raster, scattered points, or what was built of a raster. Copies are one
/// terrain.
class Terrain {
 public:
  /// The grid must outlive it.
  Terrain(const HeightGrid& grid);  // NOLINT(google-explicit-constructor): a raster is one
  explicit Terrain(std::shared_ptr<const HeightGrid> grid);
  explicit Terrain(std::shared_ptr<const TerrainOrigin> origin) : origin_(std::move(origin)) {}

  [[nodiscard]] const TerrainOrigin& origin() const { return *origin_; }
  [[nodiscard]] const HeightFrame& frame() const { return origin_->frame(); }
  [[nodiscard]] HeightRange range() const { return origin_->range(); }

 private:
  std::shared_ptr<const TerrainOrigin> origin_;
};

}  // namespace lode
