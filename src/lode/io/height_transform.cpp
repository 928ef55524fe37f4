#include "lode/io/height_transform.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <mutex>
#include <new>
#include <utility>

#include "lode/core/out_of_memory.h"
#include "lode/io/gdal_raster.h"

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

/// A run of places and heights, to be transformed in place.
struct HeightRun {
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> z;

  void clear() {
    x.clear();
    y.clear();
    z.clear();
  }
  void add(const Vec<double, 2>& at, double height) {
    x.push_back(at[0]);
    y.push_back(at[1]);
    z.push_back(height);
  }
};

/// Transforms pieces of heights in parallel, each thread with PROJ of its own.
class PieceTransformer {
 public:
  /// gather(piece, run) and scatter(piece, heights) are called once for each piece, in any order.
  using Gather = std::function<void(std::size_t, HeightRun&)>;
  using Scatter = std::function<void(std::size_t, const std::vector<double>&)>;

  PieceTransformer(const PJ* transformation, bool has_places)
      : transformation_(transformation), has_places_(has_places) {}

  Result<void> run(std::size_t n, const Gather& gather, const Scatter& scatter,
                   Progress& progress) {
    // Before threads start: what they copy is not said to be safe from several.
    std::vector<Worker> workers;
    for (std::size_t i = 0; i < std::min(n, static_cast<std::size_t>(n_workers({}))); ++i) {
      LODE_TRY(Worker worker, make_worker());
      workers.push_back(std::move(worker));
    }
    std::atomic<std::size_t> n_done{0};
    parallel_for(n, {static_cast<int>(workers.size())}, 1, [&](std::size_t piece, int number) {
      if (progress.is_cancelled() || has_failed_) return;
      Worker& worker = workers[static_cast<std::size_t>(number)];
      worker.run.clear();
      gather(piece, worker.run);
      transform(worker);
      if (!has_failed_) scatter(piece, worker.run.z);
      progress.report("transforming", static_cast<double>(++n_done) / static_cast<double>(n));
    });
    if (progress.is_cancelled()) return cancelled_error();
    if (error_) return *error_;
    return {};
  }

 private:
  struct Worker {
    Proj proj;
    Proj::Object transformation;  ///< x before y.
    HeightRun run{};
  };

  [[nodiscard]] Result<Worker> make_worker() const {
    LODE_TRY(Proj proj, Proj::make());
    const ProjLibrary& library = proj.library();
    const Proj::Object copy = proj.own(library.clone(proj.context(), transformation_));
    Proj::Object x_first =
        proj.own(copy ? library.with_x_first(proj.context(), copy.get()) : nullptr);
    if (!x_first) return fail("expected PROJ to copy a transformation, got: {}", proj.reason());
    return Worker{std::move(proj), std::move(x_first)};
  }

  void transform(Worker& worker) {
    HeightRun& run = worker.run;
    if (run.z.empty()) return;
    std::vector<double> x = run.x;
    std::vector<double> y = run.y;
    if (!has_places_) {
      std::ranges::fill(x, 0.0);
      std::ranges::fill(y, 0.0);
    }
    constexpr std::size_t kStep = sizeof(double);
    const std::size_t n = run.z.size();
    worker.proj.library().transform(worker.transformation.get(), PJ_FWD, x.data(), kStep, n,
                                    y.data(), kStep, n, run.z.data(), kStep, n, nullptr, 0, 0);
    for (std::size_t i = 0; i < n; ++i)
      if (!std::isfinite(run.z[i]))
        return refuse(
            fail("expected heights where the transformation has a grid, got one at {}, {} off it",
                 run.x[i], run.y[i]));
  }
  void refuse(Error error) {
    const std::scoped_lock lock(mutex_);
    if (!error_) error_ = std::move(error);
    has_failed_ = true;
  }

  const PJ* transformation_;
  bool has_places_;
  std::atomic<bool> has_failed_{false};
  std::mutex mutex_;
  std::optional<Error> error_;
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
  LODE_CHECK(PieceTransformer(transformation, has_places)
                 .run(
                     static_cast<std::size_t>(before.n_rows),
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
  return PieceTransformer(transformation, has_places)
      .run((points.size() + kPiece - 1) / kPiece,
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

}  // namespace

Result<VerticalOutcome> set_vertical(HeightRaster& raster, const VerticalOptions& options,
                                     Progress& progress) try {
  HeightGrid& grid = raster.grid;
  Extent extent;
  for (const double x : {0, grid.n_columns - 1})
    for (const double y : {0, grid.n_rows - 1}) extent.add(grid.world(x, y));
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
