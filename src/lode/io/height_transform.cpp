#include "lode/io/height_transform.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <new>
#include <utility>

#include "lode/core/out_of_memory.h"
#include "lode/io/gdal_raster.h"
#include "lode/io/height_pieces.h"

namespace lode::io {
namespace {

/// x and y from the lowest to the largest.
struct Extent {
  Vec<double, 2> lower{{0, 0}};
  Vec<double, 2> upper{{0, 0}};
  bool is_empty = true;

  void add(const Vec<double, 2>& p) {
    for (std::size_t i = 0; i < 2; ++i) {
      lower[i] = is_empty ? p[i] : std::min(lower[i], p[i]);
      upper[i] = is_empty ? p[i] : std::max(upper[i], p[i]);
    }
    is_empty = false;
  }
};

/// What PROJ could do to heights, in its order.
class Transformations {
 public:
  /// Of heights within `extent`, in coordinates of `horizontal`, which may be null.
  Transformations(const Proj& proj, const PJ* from, const PJ* to, PJ* horizontal,
                  const Extent& extent)
      : proj_(proj), library_(proj.library()) {
    PJ_OPERATION_FACTORY_CONTEXT* factory = library_.new_factory(proj.context(), nullptr);
    library_.set_grid_use(proj.context(), factory, PROJ_GRID_AVAILABILITY_IGNORED);
    library_.set_ballpark(proj.context(), factory, 0);
    library_.set_criterion(proj.context(), factory, PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION);
    if (horizontal != nullptr) set_area(factory, horizontal, extent);
    list_ = library_.operations(proj.context(), from, to, factory);
    library_.destroy_factory(factory);
  }
  Transformations(const Transformations&) = delete;
  Transformations& operator=(const Transformations&) = delete;
  ~Transformations() {
    if (list_ != nullptr) library_.destroy_list(list_);
  }

  /// The first that can be used. Fails, naming what others lack, where none can.
  Result<Proj::Object> choose(const std::string& from, const std::string& to,
                              VerticalOutcome& outcome) const {
    const int n = list_ == nullptr ? 0 : library_.n_listed(list_);
    std::string lacking;
    for (int i = 0; i < n; ++i) {
      Proj::Object one = proj_.own(library_.listed(proj_.context(), list_, i));
      if (!one || library_.is_ballpark(proj_.context(), one.get()) != 0) continue;
      if (library_.is_instantiable(proj_.context(), one.get()) == 0) {
        if (lacking.empty()) lacking = describe(one.get()) + " needs " + missing_grids(one.get());
        continue;
      }
      if (!lacking.empty())
        outcome.notes.push_back(fmt::format("heights are transformed by {}; {}, which PROJ has not",
                                            describe(one.get()), lacking));
      outcome.transformation = name_of(one.get());
      const double accuracy = library_.accuracy(proj_.context(), one.get());
      if (accuracy >= 0) outcome.accuracy = accuracy;
      return one;
    }
    if (!lacking.empty())
      return fail(
          "expected PROJ to have what transforms heights from {} to {}; {}, which it has not: it "
          "looks "
          "in PROJ_DATA, and for downloads needs PROJ_NETWORK=ON",
          from, to, lacking);
    return fail("expected PROJ to know how heights are transformed from {} to {}, got nothing",
                from, to);
  }

 private:
  void set_area(PJ_OPERATION_FACTORY_CONTEXT* factory, PJ* horizontal, const Extent& extent) {
    const Proj::Object angles = proj_.own(library_.create(proj_.context(), "OGC:CRS84"));
    if (!angles) return;
    const Proj::Object to_angles =
        proj_.own(library_.between(proj_.context(), horizontal, angles.get(), nullptr, nullptr));
    const Proj::Object x_first =
        proj_.own(to_angles ? library_.with_x_first(proj_.context(), to_angles.get()) : nullptr);
    if (!x_first) return;
    constexpr int kPointsPerSide = 21;
    double west = 0;
    double south = 0;
    double east = 0;
    double north = 0;
    if (library_.transform_bounds(proj_.context(), x_first.get(), PJ_FWD, extent.lower[0],
                                  extent.lower[1], extent.upper[0], extent.upper[1], &west, &south,
                                  &east, &north, kPointsPerSide) != 0)
      library_.set_area(proj_.context(), factory, west, south, east, north);
  }
  [[nodiscard]] std::string name_of(const PJ* one) const {
    const char* name = library_.name(one);
    return name == nullptr ? "unnamed" : without_controls(name);
  }
  [[nodiscard]] std::string describe(const PJ* one) const {
    const double accuracy = library_.accuracy(proj_.context(), one);
    return accuracy < 0 ? name_of(one) : fmt::format("{} (accuracy {} m)", name_of(one), accuracy);
  }
  [[nodiscard]] std::string missing_grids(const PJ* one) const {
    std::string names;
    int n_missing = 0;
    for (int i = 0; i < library_.n_grids(proj_.context(), one); ++i) {
      const char* name = nullptr;
      int is_there = 0;
      if (library_.grid(proj_.context(), one, i, &name, nullptr, nullptr, nullptr, nullptr, nullptr,
                        &is_there) == 0 ||
          is_there != 0 || name == nullptr)
        continue;
      names += (names.empty() ? "" : " and ") + without_controls(name);
      ++n_missing;
    }
    if (names.empty()) return "what PROJ does not name";
    return (n_missing == 1 ? "the grid " : "the grids ") + names;
  }

  const Proj& proj_;
  const ProjLibrary& library_;
  PJ_OBJ_LIST* list_ = nullptr;
};

/// Transforms all heights by what it is given.
using Transform = std::function<Result<void>(const PJ* transformation, bool has_places)>;

Result<VerticalOutcome> change(HeightReference& reference, const VerticalOptions& options,
                               const Extent& extent, const Transform& transform) {
  VerticalOutcome outcome;
  if (options.is_empty() && !says_heights(reference.crs)) return outcome;
  LODE_TRY(const Proj proj, Proj::make());
  LODE_TRY(const SplitCrs split,
           declare_vertical(proj, options.declared, reference, outcome.notes));
  if (options.target.empty()) return outcome;
  if (!split.vertical)
    return fail(
        "expected to know what heights are above before they are transformed, got a file that does "
        "not say; --vertical-crs does");
  LODE_TRY(const VerticalCrs target, vertical_named(proj, options.target));
  PJ* horizontal = split.horizontal.get();
  LODE_TRY(const Proj::Object from, joined(proj, horizontal, *split.vertical));
  LODE_TRY(const Proj::Object to, joined(proj, horizontal, target));
  const Transformations all(proj, from.get(), to.get(), horizontal, extent);
  LODE_TRY(const Proj::Object chosen, all.choose(split.vertical->name, target.name, outcome));
  LODE_CHECK(transform(chosen.get(), horizontal != nullptr));
  if (horizontal != nullptr) {
    LODE_TRY(reference.crs, wkt_of(proj, to.get()));
  }
  reference.unit = target.unit;
  return outcome;
}

/// A row a piece.
Result<void> transform_grid(HeightRaster& raster, const PJ* transformation, bool has_places,
                            Progress& progress) {
  const HeightGrid& before = raster.grid;
  HeightGrid after = make_height_grid<double>(before.n_columns, before.n_rows);
  static_cast<HeightFrame&>(after) = before;
  after.is_valid = before.is_valid;
  auto& samples = std::get<HeightGrid::Samples<double>>(after.heights);
  const auto for_each = [&](std::size_t row, const auto& visit) {
    const auto y = static_cast<std::int32_t>(row);
    for (std::int32_t x = 0; x < before.n_columns; ++x)
      if (before.has_height(x, y)) visit(x, y);
  };
  const auto n_rows = static_cast<std::size_t>(before.n_rows);
  LODE_TRY(const auto pieces, PieceTransformer::make(transformation, has_places, n_rows));
  LODE_CHECK(pieces->run(
      n_rows,
      [&](std::size_t row, HeightRun& run) {
        for_each(row, [&](std::int32_t x, std::int32_t y) {
          run.add(before.world(x, y), before.height(x, y));
        });
      },
      [&](std::size_t row, const std::vector<double>& heights) {
        std::size_t i = 0;
        for_each(row, [&](std::int32_t x, std::int32_t y) {
          samples[static_cast<std::size_t>(y * after.stride + x)] = heights[i++];
        });
      },
      progress));
  raster.grid = std::move(after);
  raster.type = "float64";
  return {};
}

Result<void> transform_points(std::vector<Vec3d>& points, const PJ* transformation, bool has_places,
                              Progress& progress) {
  constexpr std::size_t kPiece = 4096;
  const auto end = [&](std::size_t piece) { return std::min(points.size(), (piece + 1) * kPiece); };
  const std::size_t n_pieces = (points.size() + kPiece - 1) / kPiece;
  LODE_TRY(const auto pieces, PieceTransformer::make(transformation, has_places, n_pieces));
  return pieces->run(
      n_pieces,
      [&](std::size_t piece, HeightRun& run) {
        for (std::size_t i = piece * kPiece; i < end(piece); ++i)
          run.add({{points[i][0], points[i][1]}}, points[i][2]);
      },
      [&](std::size_t piece, const std::vector<double>& heights) {
        for (std::size_t i = piece * kPiece; i < end(piece); ++i)
          points[i][2] = heights[i - piece * kPiece];
      },
      progress);
}

Extent extent_of(const HeightFrame& frame) {
  Extent extent;
  for (const double x : {0, frame.n_columns - 1})
    for (const double y : {0, frame.n_rows - 1}) extent.add(frame.world(x, y));
  return extent;
}

}  // namespace

struct RowTransformer::Impl {
  std::unique_ptr<PieceTransformer> pieces;
};

struct RowTransformerMaker {
  static RowTransformer make(std::unique_ptr<PieceTransformer> pieces) {
    return RowTransformer(
        std::make_unique<RowTransformer::Impl>(RowTransformer::Impl{std::move(pieces)}));
  }
};

RowTransformer::RowTransformer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RowTransformer::RowTransformer(RowTransformer&&) noexcept = default;
RowTransformer& RowTransformer::operator=(RowTransformer&&) noexcept = default;
RowTransformer::~RowTransformer() = default;

Result<void> RowTransformer::transform(const HeightFrame& frame, std::int32_t first,
                                       std::int32_t n_rows, std::span<double> heights,
                                       Progress& progress) const {
  const auto n = static_cast<std::size_t>(frame.n_columns);
  const auto row_of = [&](std::size_t row) { return heights.subspan(row * n, n); };
  return impl_->pieces->run(
      static_cast<std::size_t>(n_rows),
      [&](std::size_t row, HeightRun& run) {
        const std::span<double> own = row_of(row);
        const auto y = static_cast<double>(first) + static_cast<double>(row);
        for (std::size_t x = 0; x < n; ++x)
          if (!std::isnan(own[x])) run.add(frame.world(static_cast<double>(x), y), own[x]);
      },
      [&](std::size_t row, const std::vector<double>& made) {
        std::size_t i = 0;
        for (double& z : row_of(row))
          if (!std::isnan(z)) z = made[i++];
      },
      progress);
}

Result<VerticalPlan> plan_vertical(HeightFrame& frame, const VerticalOptions& options,
                                   Progress& progress) try {
  if (progress.is_cancelled()) return cancelled_error();
  VerticalPlan plan;
  HeightReference reference{frame.crs, frame.vertical_unit};
  const auto n_rows = static_cast<std::size_t>(frame.n_rows);
  LODE_TRY(plan.outcome, change(reference, options, extent_of(frame),
                                [&](const PJ* transformation, bool has_places) -> Result<void> {
                                  LODE_TRY(auto pieces, PieceTransformer::make(transformation,
                                                                               has_places, n_rows));
                                  pieces->be_quiet();
                                  plan.rows = RowTransformerMaker::make(std::move(pieces));
                                  return {};
                                }));
  frame.crs = reference.crs;
  frame.vertical_unit = reference.unit;
  return plan;
} catch (const std::bad_alloc&) {
  return out_of_memory("transform heights");
}

Result<VerticalOutcome> set_vertical(HeightRaster& raster, const VerticalOptions& options,
                                     Progress& progress) try {
  HeightGrid& grid = raster.grid;
  const Extent extent = extent_of(grid);
  HeightReference reference{grid.crs, grid.vertical_unit};
  LODE_TRY(VerticalOutcome outcome,
           change(reference, options, extent, [&](const PJ* transformation, bool has_places) {
             return transform_grid(raster, transformation, has_places, progress);
           }));
  raster.grid.crs = reference.crs;
  raster.grid.vertical_unit = reference.unit;
  return outcome;
} catch (const std::bad_alloc&) {
  return out_of_memory("transform heights");
}

Result<VerticalOutcome> set_vertical(PointFile& file, const VerticalOptions& options,
                                     Progress& progress) try {
  Extent extent;
  if (!options.target.empty())
    for (const Vec3d& p : file.points) extent.add({{p[0], p[1]}});
  HeightReference reference{file.crs, file.vertical_unit};
  LODE_TRY(VerticalOutcome outcome,
           change(reference, options, extent, [&](const PJ* transformation, bool has_places) {
             return transform_points(file.points, transformation, has_places, progress);
           }));
  file.crs = reference.crs;
  file.vertical_unit = reference.unit;
  return outcome;
} catch (const std::bad_alloc&) {
  return out_of_memory("transform heights");
}

}  // namespace lode::io
