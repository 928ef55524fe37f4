#include "lode/delaunay/tile_insertion.h"

#include <algorithm>
#include <atomic>
#include <optional>
#include <utility>

#include "lode/delaunay/greedy_loop.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/delaunay/seams.h"
#include "lode/delaunay/tile_judge.h"
#include "lode/delaunay/tile_mesh.h"

namespace lode::delaunay {
namespace {

constexpr int kQueueTileBits = 8;  // Few tiles are larger.

/// What a thread needs for one tile after the other.
template <typename T>
struct TileMemory {
  TileMesher mesher;
  HeightGrid::Samples<T> samples{};
  LatticeTriangles triangles{};
};

/// All tiles, on all threads.
template <typename T>
class TiledInsertion {
 public:
  TiledInsertion(const SampleRows<T>& rows, const GridCells* cells, const Seams& seams,
                 const TileOptions& options, const HeightRange& range, Progress& progress)
      : rows_(rows),
        cells_(cells),
        seams_(seams),
        options_(options),
        range_(range),
        progress_(progress) {}

  Result<void> run(SeamedTiles& tiles) {
    const std::size_t n = tiles.layout.n_tiles();
    tiles.pieces.resize(n);
    std::vector<GreedyReport> reports(n);
    std::vector<std::optional<Error>> failures(n);
    std::vector<TileMemory<T>> memories(static_cast<std::size_t>(n_workers(options_.threads)),
                                        TileMemory<T>{TileMesher(seams_, cells_)});
    std::atomic<std::size_t> n_done = 0;
    parallel_for(n, options_.threads, 1, [&](std::size_t tile, int worker) {
      const auto report = refine(tile, tiles.layout.part(tile),
                                 memories[static_cast<std::size_t>(worker)], tiles.pieces[tile]);
      if (report)
        reports[tile] = *report;
      else
        failures[tile] = report.error();
      progress_.report("inserting", static_cast<double>(++n_done) / static_cast<double>(n));
    });
    for (std::size_t tile = 0; tile < n; ++tile) {
      if (failures[tile]) return *failures[tile];
      tiles.report.n_inserted += reports[tile].n_inserted;
      tiles.report.achieved_error =
          std::max(tiles.report.achieved_error, reports[tile].achieved_error);
    }
    return {};
  }

 private:
  /// Which is cancelled as a whole.
  Result<GreedyReport> refine(std::size_t tile, const LatticePart& part, TileMemory<T>& memory,
                              TilePiece& piece) {
    if (progress_.is_cancelled()) return cancelled_error();
    LODE_TRY(LatticeMesh mesh, memory.mesher.make(tile, part, std::move(memory.triangles)));
    GreedyReport report;
    if (!mesh.triangles().empty()) {
      LODE_TRY(report, insert(mesh, part, error_beside(tile), memory));
      take_out(mesh, part, piece);
    }
    memory.triangles = mesh.take_triangles();
    return report;
  }
  [[nodiscard]] double error_beside(std::size_t tile) const {
    return std::max({seams_.below(tile).error, seams_.right_of(tile).error,
                     seams_.above(tile).error, seams_.left_of(tile).error});
  }
  Result<GreedyReport> insert(LatticeMesh& mesh, const LatticePart& part, double side_error,
                              TileMemory<T>& memory) {
    const LatticePart own{{0, 0}, {part.last.x - part.first.x, part.last.y - part.first.y}};
    const SampleRows<T> rows = copy_samples(part, memory.samples);
    const SparseSamples<T> sparse(rows, own.last);
    const TriangleJudge<T> all(rows, &sparse, range_.lower, range_.upper, options_.max_error,
                               nullptr);
    const TileJudge<T> judge(all, rows, own, double_slack(range_.lower, range_.upper),
                             options_.max_error, side_error);
    const GreedyOptions options{.max_error = options_.max_error, .reports = false};
    return GreedyLoop(mesh, judge, options, progress_).run(own, kQueueTileBits);
  }
  /// So that all of a tile's rows lie together.
  SampleRows<T> copy_samples(const LatticePart& part, HeightGrid::Samples<T>& samples) const {
    const std::int32_t n_columns = part.last.x - part.first.x + 1;
    const std::int32_t n_rows = part.last.y - part.first.y + 1;
    const std::int64_t stride = padded_stride(n_columns);
    resize_anew(samples, static_cast<std::size_t>(stride * n_rows + HeightGrid::kPadding));
    for (std::int32_t y = 0; y < n_rows; ++y)
      std::copy_n(rows_.samples + (part.first.y + y) * rows_.stride + part.first.x, n_columns,
                  samples.data() + y * stride);
    return {samples.data(), stride, LatticePacking(n_columns)};
  }
  void take_out(const LatticeMesh& mesh, const LatticePart& part, TilePiece& piece) const {
    const std::size_t n = mesh.triangles().size();
    const bool has_links = options_.links == TinLinks::kept;
    piece.corners.resize(n);
    piece.twins.resize(has_links ? n : 0);
    piece.errors.resize(has_links ? n : 0);
    for (std::size_t t = 0; t < n; ++t) {
      const LatticeTriangle& triangle = mesh.triangles()[t];
      for (std::size_t i = 0; i < 3; ++i) {
        const LatticePoint p = mesh.nodes().unpack(triangle.corner[i]);
        piece.corners[t][i] = rows_.packing.pack({part.first.x + p.x, part.first.y + p.y});
      }
      if (!has_links) continue;
      piece.twins[t] = triangle.twin;
      piece.errors[t] = triangle.error;
    }
  }

  SampleRows<T> rows_;
  const GridCells* cells_;
  const Seams& seams_;
  const TileOptions& options_;
  HeightRange range_;
  Progress& progress_;
};

}  // namespace

template <typename T>
Result<SeamedTiles> insert_in_tiles(const HeightGrid& grid, double lower, double upper,
                                    const TileOptions& options, Progress& progress) {
  LODE_EXPECTS(options.max_error >= 0);
  LODE_CHECK(check_lattice(grid));
  std::optional<GridCells> masked;
  if (grid.n_missing() > 0) {
    masked.emplace(grid);
    LODE_CHECK(check_cells(*masked, grid));
  }
  const GridCells* cells = masked ? &*masked : nullptr;
  const auto n_valid = static_cast<std::uint64_t>(grid.n_samples()) - grid.n_missing();
  const std::uint64_t n_samples = masked ? masked->count_samples() : n_valid;
  const SampleRows<T> rows{std::get<HeightGrid::Samples<T>>(grid.heights).data(), grid.stride,
                           LatticePacking(grid.n_columns)};
  const SeamOptions wanted{.range = upper - lower,
                           .max_error = options.max_error,
                           .threads = options.threads,
                           .turn = grid.is_round ? grid.n_columns - 1 : 0};
  const LatticePoint last{grid.n_columns - 1, grid.n_rows - 1};
  const std::int32_t side =
      options.side > 0 ? options.side : choose_tile_side(last, rows, cells, wanted);
  SeamedTiles tiles{.layout = TileLayout(grid.n_columns, grid.n_rows, side),
                    .n_samples = n_samples,
                    .n_left_out = n_valid - n_samples};
  const Seams seams = find_seams(tiles.layout, rows, cells, wanted);
  LODE_CHECK(TiledInsertion<T>(rows, cells, seams, options, {lower, upper}, progress).run(tiles));
  std::uint64_t n = 0;
  for (const TilePiece& piece : tiles.pieces) n += piece.corners.size();
  if (n > kMostTriangles)
    return fail("expected up to {} triangles, got {}: a larger tolerance takes fewer",
                kMostTriangles, n);
  return tiles;
}

template Result<SeamedTiles> insert_in_tiles<std::int16_t>(const HeightGrid&, double, double,
                                                           const TileOptions&, Progress&);
template Result<SeamedTiles> insert_in_tiles<std::uint16_t>(const HeightGrid&, double, double,
                                                            const TileOptions&, Progress&);
template Result<SeamedTiles> insert_in_tiles<float>(const HeightGrid&, double, double,
                                                    const TileOptions&, Progress&);
template Result<SeamedTiles> insert_in_tiles<double>(const HeightGrid&, double, double,
                                                     const TileOptions&, Progress&);

}  // namespace lode::delaunay
