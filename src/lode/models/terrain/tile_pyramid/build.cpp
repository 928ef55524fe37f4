#include "lode/models/terrain/tile_pyramid/build.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lode/core/expects.h"
#include "lode/models/terrain/tile_pyramid/globe_lattice.h"
#include "lode/models/terrain/tile_pyramid/level_forms.h"
#include "lode/models/terrain/tile_pyramid/tile_errors.h"

namespace lode::tile_pyramid {
namespace {

/// A tile in the making.
struct TileJob {
  TileId id;
  TileMesh mesh;
  std::vector<WorstInTriangle> worst{};  ///< By triangle.
  std::vector<std::uint32_t> open{};     ///< Triangles that are to be measured.
  double error = 0;
  bool is_beyond = false;
  Result<void> status{};
};

class PyramidBuild {
 public:
  PyramidBuild(HeightRows& rows, const ExtendedRaster& raster, const BorderLines& lines,
               std::vector<TileRange> ranges, std::vector<LevelForm> forms, Threads threads,
               const TileSink& sink, Progress& progress)
      : rows_(rows),
        raster_(raster),
        lines_(lines),
        ranges_(std::move(ranges)),
        forms_(std::move(forms)),
        chains_(lines, ranges_, forms_, threads),
        threads_(threads),
        sink_(sink),
        progress_(progress),
        finished_(ranges_.size()) {
    for (std::size_t level = 0; level < ranges_.size(); ++level)
      reports_.push_back({.range = ranges_[level], .form = forms_[level]});
  }

  Result<std::vector<LevelReport>> run() {
    LODE_CHECK(make_row(0, 0));
    return std::move(reports_);
  }

 private:
  static constexpr std::int64_t kMostRowsHeld = 2 * BorderLines::kStripRows;

  /// A row of tiles, after the two finer rows in it.
  Result<void> make_row(int level, std::int64_t y) {
    const bool is_finest = level + 1 == static_cast<int>(ranges_.size());
    if (!is_finest) {
      const TileRange& finer = ranges_[static_cast<std::size_t>(level) + 1];
      for (const std::int64_t row : {2 * y, 2 * y + 1})
        if (row >= finer.first_y && row <= finer.last_y) LODE_CHECK(make_row(level + 1, row));
    }
    std::vector<TileJob> jobs = start_jobs(level, y);
    RowStrip strip(raster_);
    const IndexRange rows = rows_of(jobs.front().id, 1);
    // Tiles of more samples than these start from their sides alone.
    const bool has_samples = is_finest && rows.last - rows.first < kMostRowsHeld;
    if (has_samples) LODE_CHECK(strip.read(rows_, rows));
    LODE_CHECK(for_jobs(jobs, [&](TileJob& job) {
      return refine_by(job, has_samples ? samples_in(job.id, strip)
                            : is_finest ? std::vector<TileVertex>{}
                                        : vertices_below(job.id));
    }));
    LODE_CHECK(add_globe_nodes(jobs));
    LODE_CHECK(settle(jobs, strip));
    return finish_row(jobs);
  }

  std::vector<TileJob> start_jobs(int level, std::int64_t y) {
    const TileRange& range = ranges_[static_cast<std::size_t>(level)];
    std::vector<TileJob> jobs;
    for (std::int64_t x = range.first_x; x <= range.last_x; ++x)
      jobs.push_back({.id = {level, wrapped_column(level, x), y}, .mesh = {}});
    return jobs;
  }

  template <typename Work>
  Result<void> for_jobs(std::vector<TileJob>& jobs, const Work& work) {
    parallel_for(jobs.size(), threads_, 1, [&](std::size_t i, int) {
      jobs[i].status = progress_.is_cancelled() ? cancelled_error() : work(jobs[i]);
    });
    for (const TileJob& job : jobs) LODE_CHECK(job.status);
    return {};
  }

  Result<void> refine_by(TileJob& job, const std::vector<TileVertex>& candidates) {
    const LevelForm& form = form_of(job.id);
    job.mesh = mesh_of_sides(sides_of(job.id));
    // Candidates' heights are rounded, by up to half a step.
    const double tolerance = std::max(form.max_error - form.height_step / 2, form.max_error / 2);
    LODE_TRY(const std::uint64_t n, refine(job.mesh, candidates, tolerance, progress_));
    static_cast<void>(n);
    return {};
  }

  /// At the height of the raster's surface: that of triangles is bound at samples alone.
  Result<void> add_globe_nodes(std::vector<TileJob>& jobs) {
    if (n_globe_cells(jobs.front().id.level) == 1) return {};
    std::vector<std::vector<LatticePoint>> nodes(jobs.size());
    parallel_for(jobs.size(), threads_, 1, [&](std::size_t i, int) {
      nodes[i] = missing_globe_nodes(jobs[i].mesh, jobs[i].id.level);
    });
    std::vector<std::int32_t> rows;
    for (const auto& of_tile : nodes)
      for (const LatticePoint node : of_tile) rows.push_back(node.y);
    std::ranges::sort(rows);
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    std::vector<std::vector<TileVertex>> vertices(jobs.size());
    for (const std::int32_t y : rows) {
      if (progress_.is_cancelled()) return cancelled_error();
      const TileId& id = jobs.front().id;
      const auto row = raster_.row_at(south_of(id) + tile_size(id.level) * y / kLastNode);
      RowStrip strip(raster_);
      if (row) LODE_CHECK(strip.read(rows_, {row->first, row->first + 1}));
      for (std::size_t i = 0; i < jobs.size(); ++i)
        for (const LatticePoint node : nodes[i])
          if (node.y == y) vertices[i].push_back({node, surface_at(jobs[i].id, node, row, strip)});
    }
    parallel_for(jobs.size(), threads_, 1,
                 [&](std::size_t i, int) { insert_all(jobs[i].mesh, vertices[i]); });
    return {};
  }

  [[nodiscard]] double surface_at(const TileId& tile, LatticePoint node,
                                  const std::optional<Between>& row, const RowStrip& strip) const {
    const auto column =
        raster_.column_at(west_of(tile) + tile_size(tile.level) * node.x / kLastNode);
    const double height = row && column ? strip.surface(*column, *row) : raster_.fill();
    return rounded(height, form_of(tile).height_step);
  }

  /// Inserts worst samples until all are within the tolerance, or nothing helps.
  Result<void> settle(std::vector<TileJob>& jobs, RowStrip& strip) {
    std::vector<TileJob*> pending;
    pending.reserve(jobs.size());
    for (TileJob& job : jobs) {
      set_open(job, {});
      pending.push_back(&job);
    }
    while (!pending.empty()) {
      LODE_CHECK(measure_all(pending, strip));
      std::vector<std::uint8_t> is_done(pending.size());
      parallel_for(pending.size(), threads_, 1, [&](std::size_t i, int) {
        const Result<bool> improved = improve(*pending[i]);
        if (!improved) pending[i]->status = improved.error();
        is_done[i] = static_cast<std::uint8_t>(!improved || !*improved);
      });
      std::vector<TileJob*> rest;
      for (std::size_t i = 0; i < pending.size(); ++i) {
        LODE_CHECK(pending[i]->status);
        if (is_done[i] == 0) rest.push_back(pending[i]);
      }
      pending = std::move(rest);
    }
    return {};
  }

  Result<void> measure_all(const std::vector<TileJob*>& pending, RowStrip& strip) {
    struct Part {
      TileJob* job;
      std::span<const std::uint32_t> triangles;
    };
    constexpr std::size_t kPart = 512;
    std::vector<Part> parts;
    for (TileJob* job : pending)
      for (std::size_t first = 0; first < job->open.size(); first += kPart) {
        const std::size_t n = std::min(kPart, job->open.size() - first);
        parts.push_back({job, std::span(job->open).subspan(first, n)});
      }
    const IndexRange all = rows_of(pending.front()->id, 0);
    const bool is_held = all.first >= strip.rows().first && all.last <= strip.rows().last;
    const std::int64_t n_rows = is_held ? all.last - all.first + 1 : BorderLines::kStripRows;
    for (std::int64_t first = all.first; first <= all.last; first += n_rows) {
      if (progress_.is_cancelled()) return cancelled_error();
      const IndexRange rows{first, std::min(first + n_rows - 1, all.last)};
      if (!is_held) LODE_CHECK(strip.read(rows_, rows));
      parallel_for(parts.size(), threads_, 1, [&](std::size_t i, int) {
        const Part& part = parts[i];
        measure(part.job->mesh, part.job->id, raster_, strip, rows, part.triangles,
                part.job->worst);
      });
    }
    return {};
  }

  /// Whether there is more to measure.
  Result<bool> improve(TileJob& job) {
    const LevelForm& form = form_of(job.id);
    job.error = 0;
    std::vector<TileVertex> candidates;
    for (const WorstInTriangle& worst : job.worst) {
      job.error = std::max(job.error, worst.error);
      if (worst.error > form.max_error)
        candidates.push_back({node_of(job.id, raster_, worst.column, worst.row, worst.turn),
                              rounded(worst.height, form.height_step)});
    }
    job.is_beyond = !candidates.empty();
    if (!job.is_beyond) return false;
    const auto before = job.mesh.triangles;
    LODE_TRY(std::uint64_t n, refine(job.mesh, candidates, 0, progress_));
    if (n == 0) {
      LODE_TRY(n, refine(job.mesh, beside(candidates), 0, progress_));
    }
    set_open(job, before);
    return n > 0;
  }

  /// Where samples have their vertices and yet are too far off, beside a cliff half a node away,
  /// nodes all round are as high.
  static std::vector<TileVertex> beside(const std::vector<TileVertex>& vertices) {
    std::vector<TileVertex> nodes;
    nodes.reserve(9 * vertices.size());
    for (const TileVertex& vertex : vertices)
      for (const std::int32_t y : {-1, 0, 1})
        for (const std::int32_t x : {-1, 0, 1})
          nodes.push_back({{vertex.node.x + x, vertex.node.y + y}, vertex.height});
    return nodes;
  }

  /// All triangles that are not as before: vertices keep their numbers, and so do triangles.
  static void set_open(TileJob& job, std::span<const std::array<std::uint32_t, 3>> before) {
    const auto& triangles = job.mesh.triangles;
    job.worst.resize(triangles.size());
    job.open.clear();
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      if (t < before.size() && triangles[t] == before[t]) continue;
      job.open.push_back(t);
      job.worst[t] = {};
    }
  }

  Result<void> finish_row(std::vector<TileJob>& jobs) {
    LODE_CHECK(for_jobs(jobs, [&](TileJob& job) {
      return sink_({job.id, job.mesh, form_of(job.id), job.error});
    }));
    const auto level = static_cast<std::size_t>(jobs.front().id.level);
    LevelReport& report = reports_[level];
    auto& row = finished_[level][static_cast<std::size_t>(jobs.front().id.y % 2)];
    row.clear();
    for (TileJob& job : jobs) {
      report.error = std::max(report.error, job.error);
      report.n_beyond += job.is_beyond ? 1 : 0;
      report.n_triangles += job.mesh.triangles.size();
      report.n_vertices += job.mesh.vertices.size();
      row.push_back(std::move(job.mesh.vertices));
    }
    n_finished_ += jobs.size();
    std::uint64_t n_all = 0;
    for (const TileRange& range : ranges_) n_all += range.n_tiles();
    progress_.report("tiles", static_cast<double>(n_finished_) / static_cast<double>(n_all));
    return {};
  }

  [[nodiscard]] const LevelForm& form_of(const TileId& tile) const {
    return forms_[static_cast<std::size_t>(tile.level)];
  }

  /// Of the samples in a row of tiles; `beyond` > 0: and margins, and so many more.
  [[nodiscard]] IndexRange rows_of(const TileId& tile, std::int64_t beyond) const {
    const double south = south_of(tile);
    const std::int64_t lowest = beyond > 0 ? -ExtendedRaster::kMargin : 0;
    return raster_.rows_between(south, south + tile_size(tile.level), lowest, beyond);
  }

  /// Of the tile's corner in the south-west. There four tiles meet, and all have it from the side
  /// that begins there: where another ends rounding may see a height on the other side of a half.
  [[nodiscard]] double corner_height(const TileId& tile) const {
    return lines_.profile({tile, true}).height(0);
  }

  std::vector<TileVertex> sides_of(const TileId& tile) const {
    std::vector<TileVertex> sides;
    const auto add = [&](const TileSide& side, std::int32_t offset) {
      const Profile profile = lines_.profile(side);
      for (const std::uint16_t node : chains_.nodes(side)) {
        const LatticePoint at =
            side.is_west ? LatticePoint{offset, node} : LatticePoint{node, offset};
        const bool is_corner = node == 0 || node == kLastNode;
        if (is_corner && !side.is_west) continue;
        const double height = node == kLastNode
                                  ? corner_height({tile.level, side.tile.x, side.tile.y + 1})
                                  : profile.height(node);
        sides.push_back({at, rounded(height, form_of(tile).height_step)});
      }
    };
    const std::int64_t east = wrapped_column(tile.level, tile.x + 1);
    add({tile, true}, 0);
    add({{tile.level, east, tile.y}, true}, kLastNode);
    add({tile, false}, 0);
    add({{tile.level, tile.x, tile.y + 1}, false}, kLastNode);
    return sides;
  }

  /// In rows, with margins.
  std::vector<TileVertex> samples_in(const TileId& tile, const RowStrip& strip) const {
    const double west = west_of(tile);
    const IndexRange rows = rows_of(tile, 1);
    const double step = form_of(tile).height_step;
    std::vector<TileVertex> samples;
    for (int turn = ExtendedRaster::kFirstTurn; turn <= ExtendedRaster::kLastTurn; ++turn) {
      const IndexRange columns = raster_.columns_between(west, west + tile_size(tile.level), turn,
                                                         -ExtendedRaster::kMargin, 0);
      for (std::int64_t row = rows.first; row <= rows.last; ++row)
        for (std::int64_t column = columns.first; column <= columns.last; ++column) {
          const LatticePoint node = node_of(tile, raster_, column, row, turn);
          samples.push_back({node, rounded(strip.height(column, row), step)});
        }
    }
    return samples;
  }

  /// Of the four tiles, where they are; those on sides that they share twice.
  std::vector<TileVertex> vertices_below(const TileId& tile) const {
    const TileRange& finer = ranges_[static_cast<std::size_t>(tile.level) + 1];
    const double step = form_of(tile).height_step;
    std::vector<TileVertex> vertices;
    for (std::int64_t y = 2 * tile.y; y < 2 * tile.y + 2; ++y)
      for (std::int64_t x = 2 * tile.x; x < 2 * tile.x + 2; ++x) {
        const LatticePoint origin{static_cast<std::int32_t>(x % 2) * kLastNode,
                                  static_cast<std::int32_t>(y % 2) * kLastNode};
        if (!finer.holds(x, y)) {
          add_square(origin, step, vertices);
          continue;
        }
        const auto column =
            static_cast<std::size_t>(wrapped_column(finer.level, x - finer.first_x));
        const auto& rows = finished_[static_cast<std::size_t>(finer.level)];
        for (const TileVertex& vertex : rows[static_cast<std::size_t>(y % 2)][column])
          vertices.push_back(
              {{(origin.x + vertex.node.x + 1) / 2, (origin.y + vertex.node.y + 1) / 2},
               rounded(vertex.height, step)});
      }
    return vertices;
  }
  void add_square(LatticePoint origin, double step, std::vector<TileVertex>& vertices) const {
    const double height = rounded(raster_.fill(), step);
    for (const std::int32_t y : {0, kLastNode})
      for (const std::int32_t x : {0, kLastNode})
        vertices.push_back({{(origin.x + x + 1) / 2, (origin.y + y + 1) / 2}, height});
  }

  HeightRows& rows_;
  const ExtendedRaster& raster_;
  const BorderLines& lines_;
  std::vector<TileRange> ranges_;
  std::vector<LevelForm> forms_;
  BorderChains chains_;
  Threads threads_;
  const TileSink& sink_;
  Progress& progress_;
  std::vector<LevelReport> reports_;
  /// By level, row (odd or even) and column: vertices of the tiles last made.
  std::vector<std::array<std::vector<std::vector<TileVertex>>, 2>> finished_;
  std::uint64_t n_finished_ = 0;
};

}  // namespace

Result<std::vector<LevelReport>> build_tiles(HeightRows& rows, const TileBuildOptions& options,
                                             const TileSink& sink, Progress& progress) {
  LODE_EXPECTS(options.max_error > 0 && std::abs(options.fill) <= kMostHeight);
  LODE_TRY(const ExtendedRaster raster, ExtendedRaster::of(rows.frame(), options.fill));
  const int last = options.max_level.value_or(finest_level(raster));
  const std::vector<TileRange> ranges = tiles_of(raster.box(), last);
  if (!options.max_level)
    if (const auto few = check_number_of_tiles(ranges); !few)
      return fail("{}: {}", rows.name(), few.error().message);
  LODE_TRY(const BorderLines lines,
           BorderLines::scan(rows, raster, ranges.back(), options.threads, progress));
  std::vector<LevelForm> forms = level_forms(lines, ranges, options.fill, options.max_error);
  return PyramidBuild(rows, raster, lines, ranges, std::move(forms), options.threads, sink,
                      progress)
      .run();
}

}  // namespace lode::tile_pyramid
