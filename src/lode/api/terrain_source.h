#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/height_grid.h"
#include "lode/core/lattice_point.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/predicates.h"
#include "lode/delaunay/tin.h"
#include "lode/locate/tin_profile.h"

namespace lode {

struct SelectedTerrain;
struct TerrainOptions;
struct TerrainReport;

/// A mesh of which parts can be had without making all of it. Const members are safe from many
/// threads.
class TerrainParts {
 public:
  virtual ~TerrainParts() = default;
  /// Of all of the mesh.
  [[nodiscard]] virtual const TerrainReport& report() const = 0;
  /// Columns and rows of the outermost vertices.
  [[nodiscard]] virtual LatticePoint lower() const = 0;
  [[nodiscard]] virtual LatticePoint upper() const = 0;
  /// The triangles that hold some places (columns and rows), with their edges, in the order of the
  /// mesh, with heights, errors and twins among each other.
  [[nodiscard]] virtual Result<delaunay::Tin> around(std::span<const delaunay::Point> places,
                                                     Progress& progress) const = 0;
  /// The same of those that a segment meets, and perhaps of some beside it.
  [[nodiscard]] virtual Result<delaunay::Tin> along(const delaunay::Point& a,
                                                    const delaunay::Point& b,
                                                    Progress& progress) const = 0;
  /// The same of those that meet a rectangle of columns and rows, and of some beside it; nothing
  /// where that takes all of the mesh.
  [[nodiscard]] virtual Result<std::optional<delaunay::Tin>> within(const delaunay::Point& lower,
                                                                    const delaunay::Point& upper,
                                                                    Progress& progress) const;
  /// The same of those that have one of some heights, which rise strictly, at a corner or between,
  /// and of others.
  [[nodiscard]] virtual Result<std::optional<delaunay::Tin>> crossing(
      std::span<const double> heights, Progress& progress) const;
  /// Of all vertices; nothing where that takes all of the mesh.
  [[nodiscard]] virtual Result<std::optional<HeightRange>> height_range(Progress& progress) const;
};

/// A surface of patches, each with its own error, that need not meet: what a model has whose
/// triangles leave gaps. Patches are closed; where several meet the smallest has the place, of
/// equal ones that of the least row, then column, then the lower half. Const members are safe from
/// many threads.
class TerrainPatches {
 public:
  struct Height {
    double height = 0;
    double rounding = 0;
    double error = 0;  ///< Of the patch.
  };

  virtual ~TerrainPatches() = default;
  [[nodiscard]] virtual const TerrainReport& report() const = 0;
  /// Columns and rows of the outermost corners.
  [[nodiscard]] virtual LatticePoint lower() const = 0;
  [[nodiscard]] virtual LatticePoint upper() const = 0;
  /// At a column and row; nothing outside of the domain.
  [[nodiscard]] virtual std::optional<Height> height_at(const delaunay::Point& at) const = 0;
  /// As tin_profile() of a TIN, with a point at the end of each patch on the segment, and two where
  /// patches do not meet. Errors hold of what is linear between points: what bends is cut, and what
  /// is left of that counts.
  [[nodiscard]] virtual std::vector<ProfilePoint> profile(const delaunay::Point& a,
                                                          const delaunay::Point& b) const = 0;
};

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
  /// The same with twins and errors, though triangles leave gaps: those that have not the whole
  /// edge in common have no twin there.
  [[nodiscard]] virtual Result<SelectedTerrain> select_triangles(const TerrainOptions& options,
                                                                 Progress& progress) const;
  /// The mesh that select() would make, where it has one in parts, else null. Fails as select()
  /// does.
  [[nodiscard]] virtual Result<std::shared_ptr<const TerrainParts>> parts(
      const TerrainOptions& options) const;
  /// The patches that select() makes triangles of, where these leave gaps, else null; errors hold
  /// everywhere where the options have samples. Fails as select() does.
  [[nodiscard]] virtual Result<std::shared_ptr<const TerrainPatches>> patches(
      const TerrainOptions& options, Progress& progress) const;
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
