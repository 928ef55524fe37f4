#include "lode/api/tile_verification.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <new>
#include <numeric>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "lode/api/tile_layer.h"
#include "lode/api/tile_raster.h"
#include "lode/core/out_of_memory.h"
#include "lode/delaunay/lattice.h"
#include "lode/models/terrain/tile_pyramid/border_lines.h"
#include "lode/models/terrain/tile_pyramid/tile_errors.h"

namespace lode {
namespace {

using tile_pyramid::ExtendedRaster;
using tile_pyramid::IndexRange;
using tile_pyramid::kLastNode;
using tile_pyramid::RowStrip;
using tile_pyramid::TileId;
using tile_pyramid::TileMesh;
using tile_pyramid::TileRange;
using tile_pyramid::WorstInTriangle;

enum Side : std::size_t { west, south, east, north };
/// Heights by node along a side.
using SideHeights = std::vector<std::pair<std::int32_t, double>>;

struct TileSides {
  std::array<SideHeights, 4> sides;
};

struct DecodedTile {
  TileMesh mesh;
  TileSides sides;
};

DecodedTile to_decoded(const io::QuantizedMesh& mesh) {
  DecodedTile tile;
  tile.mesh.triangles = mesh.triangles;
  for (std::size_t v = 0; v < mesh.nodes.size(); ++v) {
    const auto [x, y] = mesh.nodes[v];
    const double z = mesh.height(v);
    tile.mesh.vertices.push_back({mesh.nodes[v], z});
    if (x == 0) tile.sides.sides[west].emplace_back(y, z);
    if (x == kLastNode) tile.sides.sides[east].emplace_back(y, z);
    if (y == 0) tile.sides.sides[south].emplace_back(x, z);
    if (y == kLastNode) tile.sides.sides[north].emplace_back(x, z);
  }
  for (SideHeights& side : tile.sides.sides) std::ranges::sort(side);
  return tile;
}

/// Whether triangles turn left, fill the square, and have one on each side of every edge within it.
/// A mesh of which that is so covers the square once.
bool covers_square(const TileMesh& mesh) {
  std::int64_t area = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  const auto node = [&](std::uint32_t v) { return mesh.vertices[v].node; };
  for (const auto& t : mesh.triangles) {
    const std::int64_t own = delaunay::doubled_area(node(t[0]), node(t[1]), node(t[2]));
    if (own <= 0) return false;
    area += own;
    for (std::size_t i = 0; i < 3; ++i) edges.emplace_back(t[i], t[(i + 1) % 3]);
  }
  std::ranges::sort(edges);
  if (std::ranges::adjacent_find(edges) != edges.end()) return false;
  const auto is_on_side = [&](std::uint32_t a, std::uint32_t b) {
    const LatticePoint p = node(a);
    const LatticePoint q = node(b);
    return (p.x == q.x && p.x % kLastNode == 0) || (p.y == q.y && p.y % kLastNode == 0);
  };
  for (const auto& [a, b] : edges) {
    const bool is_shared = std::ranges::binary_search(edges, std::pair(b, a));
    if (!is_shared && !is_on_side(a, b)) return false;
  }
  return area == 2 * std::int64_t{kLastNode} * kLastNode;
}

/// Decoded in floating point, from two minima.
bool are_equal(const SideHeights& a, const SideHeights& b) {
  constexpr double kRounding = 1e-12;
  return std::ranges::equal(a, b, [](const auto& p, const auto& q) {
    return p.first == q.first &&
           std::abs(p.second - q.second) <= kRounding * (1 + std::abs(p.second));
  });
}

/// Whether nodes of a parent's side are among those of a child's, in the half that it has.
bool holds_nodes(const SideHeights& fine, const SideHeights& coarse, std::int64_t half) {
  for (const auto& [node, z] : coarse) {
    const std::int64_t at = 2 * std::int64_t{node} - half * kLastNode;
    if (at < 0 || at > kLastNode) continue;
    const auto found =
        std::ranges::lower_bound(fine, at, {}, [](const auto& p) { return p.first; });
    if (found == fine.end() || found->first != at) return false;
  }
  return true;
}

struct Count {
  std::uint64_t n = 0;
  std::uint64_t n_failed = 0;
  std::string first{};

  void add(bool is_good, const TileId& tile, std::string_view detail = {}) {
    ++n;
    if (is_good) return;
    if (n_failed++ == 0) first = fmt::format("tile {}/{}/{}{}", tile.level, tile.x, tile.y, detail);
  }
};

class TileVerifier {
 public:
  TileVerifier(const std::string& folder, const TileLayer& layer, Threads threads,
               Progress& progress)
      : folder_(folder), layer_(layer), threads_(threads), progress_(progress) {}

  /// Without `rows` only what tiles say.
  Result<VerifyReport> run(tile_pyramid::HeightRows* rows, const ExtendedRaster* raster) {
    for (std::size_t level = 0; level < layer_.levels.size(); ++level) {
      LODE_CHECK(check_level(static_cast<int>(level), rows, raster));
      if (!unreadable_.empty()) break;
    }
    VerifyReport report;
    report.add("tiles are there and whole", decoded_.n, decoded_.n_failed, unreadable_);
    report.add("each tile covers its square once", squares_.n, squares_.n_failed, squares_.first);
    report.add("spheres hold their tiles, and occlusion points are outside", bounds_.n,
               bounds_.n_failed, bounds_.first);
    report.add("each level has tiles, and each tile a parent", parents_.n, parents_.n_failed,
               parents_.first);
    report.add("tiles of a level meet", borders_.n, borders_.n_failed, borders_.first);
    report.add("sides have the vertices of coarser ones", nested_.n, nested_.n_failed,
               nested_.first);
    if (rows != nullptr && unreadable_.empty()) report.checks.push_back(coverage_);
    if (rows != nullptr && unreadable_.empty())
      report.checks.insert(report.checks.end(), errors_.begin(), errors_.end());
    return report;
  }

 private:
  using Sides = std::map<std::pair<std::int64_t, std::int64_t>, TileSides>;

  Result<void> check_level(int level, tile_pyramid::HeightRows* rows,
                           const ExtendedRaster* raster) {
    const TileLayer::Level& own = layer_.levels[static_cast<std::size_t>(level)];
    Sides sides;
    double worst = 0;
    std::uint64_t n_tiles = 0;
    for (const TileRange& range : own.ranges)
      for (std::int64_t y = range.first_y; y <= range.last_y; ++y) {
        if (progress_.is_cancelled()) return cancelled_error();
        LODE_TRY(const double error, check_row(range, y, rows, raster, sides));
        if (!unreadable_.empty()) return {};
        worst = std::max(worst, error);
        n_tiles += static_cast<std::uint64_t>(range.n_columns());
      }
    compare_sides(level, sides);
    if (sides.empty()) parents_.add(false, {level, 0, 0});
    if (rows != nullptr) {
      add_coverage(tile_pyramid::tiles_of(raster->box(), level).back(), sides);
      add_error(level, worst, n_tiles);
    }
    coarser_ = std::move(sides);
    return {};
  }

  /// Whether all tiles are there that the raster has samples in.
  void add_coverage(const TileRange& wanted, const Sides& sides) {
    coverage_.count += wanted.n_tiles();
    if (!coverage_.passed) return;
    for (std::int64_t y = wanted.first_y; y <= wanted.last_y; ++y)
      for (std::int64_t x = wanted.first_x; x <= wanted.last_x; ++x) {
        const std::int64_t column = tile_pyramid::wrapped_column(wanted.level, x);
        if (sides.contains({column, y})) continue;
        coverage_.passed = false;
        coverage_.detail = fmt::format("no tile {}/{}/{}", wanted.level, column, y);
        return;
      }
  }

  void add_error(int level, double worst, std::uint64_t n_tiles) {
    const auto& stated = layer_.levels[static_cast<std::size_t>(level)].error;
    // Heights are decoded in floating point.
    constexpr double kRounding = 1e-9;
    const std::string said = stated ? fmt::format(", stated {}", *stated) : ", none is stated";
    errors_.push_back({fmt::format("error of level {}, at all samples", level), n_tiles,
                       !stated || worst <= *stated * (1 + kRounding) + kRounding,
                       fmt::format("measured {} m{}", worst, said)});
  }

  /// Returns the largest error in it.
  Result<double> check_row(const TileRange& range, std::int64_t y, tile_pyramid::HeightRows* rows,
                           const ExtendedRaster* raster, Sides& sides) {
    std::vector<DecodedTile> tiles;
    for (std::int64_t x = range.first_x; x <= range.last_x; ++x) {
      const auto mesh = read_tile(folder_, {range.level, x, y});
      decoded_.add(mesh.has_value(), {range.level, x, y});
      if (!mesh) {
        unreadable_ = mesh.error().message;
        return 0.0;
      }
      const auto bounded = io::check_bounds(*mesh);
      bounds_.add(bounded.has_value(), {range.level, x, y},
                  bounded ? "" : ": " + bounded.error().message);
      tiles.push_back(to_decoded(*mesh));
      squares_.add(covers_square(tiles.back().mesh), {range.level, x, y});
      sides[{x, y}] = tiles.back().sides;
    }
    if (rows == nullptr) return 0.0;
    return measure_row(range, y, tiles, *rows, *raster);
  }

  Result<double> measure_row(const TileRange& range, std::int64_t y,
                             const std::vector<DecodedTile>& tiles, tile_pyramid::HeightRows& rows,
                             const ExtendedRaster& raster) {
    constexpr std::int64_t kStrip = tile_pyramid::BorderLines::kStripRows;
    const double from = tile_pyramid::south_of({range.level, 0, y});
    const IndexRange all =
        raster.rows_between(from, from + tile_pyramid::tile_size(range.level), 0, 0);
    std::vector<double> worst(tiles.size());
    RowStrip strip(raster);
    for (std::int64_t first = all.first; first <= all.last; first += kStrip) {
      if (progress_.is_cancelled()) return cancelled_error();
      const IndexRange held{first, std::min(first + kStrip - 1, all.last)};
      LODE_CHECK(strip.read(rows, held));
      parallel_for(tiles.size(), threads_, 1, [&](std::size_t i, int) {
        const TileMesh& mesh = tiles[i].mesh;
        std::vector<WorstInTriangle> found(mesh.triangles.size());
        const TileId id{range.level, range.first_x + static_cast<std::int64_t>(i), y};
        std::vector<std::uint32_t> every(mesh.triangles.size());
        std::iota(every.begin(), every.end(), 0U);
        measure(mesh, id, raster, strip, held, every, found);
        for (const WorstInTriangle& one : found) worst[i] = std::max(worst[i], one.error);
      });
    }
    return worst.empty() ? 0.0 : std::ranges::max(worst);
  }

  void compare_sides(int level, const Sides& sides) {
    for (const auto& [key, tile] : sides) {
      const auto& [x, y] = key;
      const TileId id{level, x, y};
      const auto next = sides.find({tile_pyramid::wrapped_column(level, x + 1), y});
      if (next != sides.end())
        borders_.add(are_equal(tile.sides[east], next->second.sides[west]), id);
      if (const auto above = sides.find({x, y + 1}); above != sides.end())
        borders_.add(are_equal(tile.sides[north], above->second.sides[south]), id);
      const auto parent = coarser_.find({x / 2, y / 2});
      if (level == 0) continue;
      parents_.add(parent != coarser_.end(), id);
      if (parent == coarser_.end()) continue;
      const Side across = x % 2 == 0 ? west : east;
      const Side along = y % 2 == 0 ? south : north;
      nested_.add(holds_nodes(tile.sides[across], parent->second.sides[across], y % 2) &&
                      holds_nodes(tile.sides[along], parent->second.sides[along], x % 2),
                  id);
    }
  }

  const std::string& folder_;
  const TileLayer& layer_;
  Threads threads_;
  Progress& progress_;
  Count decoded_, squares_, bounds_, parents_, borders_, nested_;
  std::string unreadable_;
  VerifyReport::Check coverage_{"tiles cover the raster, on every level", 0, true, {}};
  std::vector<VerifyReport::Check> errors_;
  Sides coarser_;  ///< Of the level before.
};

}  // namespace

bool holds_tiles(const std::string& path) {
  std::error_code status;
  return std::filesystem::is_regular_file(std::filesystem::path(path) / "layer.json", status);
}

Result<TileVerification> verify_tiles(const std::string& folder, const TileVerifyOptions& options,
                                      Progress& progress) try {
  LODE_TRY(const TileLayer layer, read_layer(folder));
  TileVerifier verifier(folder, layer, options.threads, progress);
  TileVerification out;
  if (options.original.empty()) {
    LODE_TRY(out.report, verifier.run(nullptr, nullptr));
    return out;
  }
  LODE_TRY(const TileRaster original,
           open_tile_raster(options.original, options.reading, options.most_bytes, progress));
  auto place = ExtendedRaster::of(original.rows->frame(), 0);
  if (!place) return fail("{}: {}", options.original, place.error().message);
  out.vertical = original.vertical;
  LODE_TRY(out.report, verifier.run(original.rows.get(), &*place));
  return out;
} catch (const std::bad_alloc&) {
  return out_of_memory("verify tiles", folder);
}

}  // namespace lode
