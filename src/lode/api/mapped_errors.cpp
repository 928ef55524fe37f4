#include "lode/api/mapped_errors.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>

#include "lode/locate/plane_locator.h"

namespace lode {
namespace {

using Places = std::vector<Vec<double, 2>>;

/// Samples that are mapped together.
constexpr std::size_t kMappedAtOnce = 4096;

/// Columns and rows, both ends included.
struct SampleRectangle {
  LatticePoint lower;
  LatticePoint upper;

  [[nodiscard]] std::int64_t n_columns() const { return std::int64_t{upper.x} - lower.x + 1; }
  [[nodiscard]] std::int64_t size() const {
    return n_columns() * (std::int64_t{upper.y} - lower.y + 1);
  }
  [[nodiscard]] bool holds(const LatticePoint& p) const {
    return p.x >= lower.x && p.x <= upper.x && p.y >= lower.y && p.y <= upper.y;
  }
};

/// Where a TIN has vertices, on a lattice whose nodes are `scale` of its nodes apart.
SampleRectangle rectangle_of(const delaunay::Tin& tin, std::int32_t scale) {
  SampleRectangle all{tin.vertices.front(), tin.vertices.front()};
  for (const LatticePoint& p : tin.vertices) {
    all.lower = {std::min(all.lower.x, p.x), std::min(all.lower.y, p.y)};
    all.upper = {std::max(all.upper.x, p.x), std::max(all.upper.y, p.y)};
  }
  return {{all.lower.x / scale, all.lower.y / scale},
          {(all.upper.x + scale - 1) / scale, (all.upper.y + scale - 1) / scale}};
}

/// Samples in pieces, which are mapped at once: those in the rectangle of a TIN.
class SamplePieces {
 public:
  struct Piece {
    std::vector<LatticePoint> nodes;
    std::vector<double> heights;
    Places world;
  };

  SamplePieces(const MeasuredSamples& samples, const MappedTin& mapped)
      : samples_(samples),
        scale_((mapped.frame.n_columns - 1) / std::max(frame().n_columns - 1, 1)),
        rectangle_(rectangle_of(mapped.tin, scale_)) {}

  /// Of the TIN's nodes, how far samples are apart.
  [[nodiscard]] std::int32_t scale() const { return scale_; }
  [[nodiscard]] std::size_t size() const {
    const HeightGrid* const grid = raster();
    const std::size_t n =
        grid != nullptr ? static_cast<std::size_t>(rectangle_.size()) : nodes().nodes.size();
    return (n + kMappedAtOnce - 1) / kMappedAtOnce;
  }
  void fill(std::size_t number, Piece& piece) const {
    piece.nodes.clear();
    piece.heights.clear();
    piece.world.clear();
    if (const HeightGrid* const grid = raster())
      fill_of(*grid, number, piece);
    else
      fill_of(nodes(), number, piece);
    for (const LatticePoint& p : piece.nodes) piece.world.push_back(frame().world(p.x, p.y));
  }

 private:
  [[nodiscard]] const HeightFrame& frame() const {
    if (const HeightGrid* const grid = raster()) return *grid;
    return nodes().frame;
  }
  [[nodiscard]] const HeightGrid* raster() const {
    const auto* grid = std::get_if<std::shared_ptr<const HeightGrid>>(&samples_);
    return grid == nullptr ? nullptr : grid->get();
  }
  [[nodiscard]] const NodeHeights& nodes() const {
    return *std::get<std::shared_ptr<const NodeHeights>>(samples_);
  }
  static bool has_cell(const HeightGrid& grid, std::int32_t x, std::int32_t y) {
    if (x < 0 || y < 0 || x + 1 >= grid.n_columns || y + 1 >= grid.n_rows) return false;
    return grid.is_valid.empty() || (grid.has_height(x, y) && grid.has_height(x + 1, y) &&
                                     grid.has_height(x, y + 1) && grid.has_height(x + 1, y + 1));
  }
  void fill_of(const HeightGrid& grid, std::size_t number, Piece& piece) const {
    const auto first = static_cast<std::int64_t>(number * kMappedAtOnce);
    const std::int64_t last =
        std::min(first + static_cast<std::int64_t>(kMappedAtOnce), rectangle_.size());
    for (std::int64_t i = first; i < last; ++i) {
      const auto x = static_cast<std::int32_t>(rectangle_.lower.x + i % rectangle_.n_columns());
      const auto y = static_cast<std::int32_t>(rectangle_.lower.y + i / rectangle_.n_columns());
      const bool is_in_cell = has_cell(grid, x, y) || has_cell(grid, x - 1, y) ||
                              has_cell(grid, x, y - 1) || has_cell(grid, x - 1, y - 1);
      if (!is_in_cell) continue;
      piece.nodes.push_back({x, y});
      piece.heights.push_back(grid.height(x, y));
    }
  }
  void fill_of(const NodeHeights& all, std::size_t number, Piece& piece) const {
    const std::size_t last = std::min((number + 1) * kMappedAtOnce, all.nodes.size());
    for (std::size_t i = number * kMappedAtOnce; i < last; ++i) {
      if (!rectangle_.holds(all.nodes[i])) continue;
      piece.nodes.push_back(all.nodes[i]);
      piece.heights.push_back(all.heights[i]);
    }
  }

  const MeasuredSamples& samples_;
  std::int32_t scale_;
  SampleRectangle rectangle_;
};

/// What one piece of samples has.
struct PieceErrors {
  std::uint64_t n_samples = 0;
  std::uint64_t n_without = 0;
  std::uint64_t n_unmapped = 0;
  long double error = 0;
  Vec<double, 2> worst{};
  Vec<double, 2> unmapped{};  ///< The first.
};

class MappedMeasure {
 public:
  MappedMeasure(const MappedTin& mapped, const SamplePieces& pieces)
      : mapped_(mapped),
        triangles_(turning_left_in_world(mapped.tin, mapped.frame)),
        in_plane_(mapped.places, triangles_),
        scale_(pieces.scale()) {}

  [[nodiscard]] PieceErrors look_at(const SamplePieces::Piece& piece, const Places& places) const {
    PieceErrors found;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const bool is_place = std::isfinite(places[i][0]) && std::isfinite(places[i][1]);
      const std::optional<long double> error =
          is_place ? error_at(places[i], piece.heights[i]) : std::nullopt;
      if (error) {
        ++found.n_samples;
        if (*error > found.error || found.n_samples == 1) {
          found.error = *error;
          found.worst = piece.world[i];
        }
      } else if (is_on_lattice(piece.nodes[i])) {
        ++found.n_without;
        if (!is_place && found.n_unmapped++ == 0) found.unmapped = piece.world[i];
      }
    }
    return found;
  }

 private:
  [[nodiscard]] std::optional<long double> error_at(const Vec<double, 2>& at, double height) const {
    std::optional<long double> error;
    in_plane_.visit(at, [&](std::uint32_t t) {
      error = std::max(error.value_or(0), std::abs(height_on(t, at) - height));
    });
    return error;
  }
  [[nodiscard]] long double height_on(std::uint32_t t, const Vec<double, 2>& at) const {
    const std::uint32_t a = triangles_[t][0];
    const std::uint32_t b = triangles_[t][1];
    const std::uint32_t c = triangles_[t][2];
    const auto side = [&](std::uint32_t v, std::size_t axis) {
      return static_cast<long double>(mapped_.places[v][axis]) - mapped_.places[a][axis];
    };
    const long double x = static_cast<long double>(at[0]) - mapped_.places[a][0];
    const long double y = static_cast<long double>(at[1]) - mapped_.places[a][1];
    const long double area = side(b, 0) * side(c, 1) - side(c, 0) * side(b, 1);
    const long double of_b = (x * side(c, 1) - side(c, 0) * y) / area;
    const long double of_c = (side(b, 0) * y - x * side(b, 1)) / area;
    const auto& z = mapped_.tin.heights;
    const long double base = z[a];
    return base + of_b * (z[b] - base) + of_c * (z[c] - base);
  }
  /// Found only by those that are not in the plane.
  [[nodiscard]] bool is_on_lattice(const LatticePoint& node) const {
    std::call_once(has_lattice_, [this] {
      for (const LatticePoint& p : mapped_.tin.vertices)
        nodes_.push_back({{static_cast<double>(p.x), static_cast<double>(p.y)}});
      on_lattice_.emplace(nodes_, mapped_.tin.triangles);
    });
    bool is_there = false;
    on_lattice_->visit(
        {{static_cast<double>(node.x) * scale_, static_cast<double>(node.y) * scale_}},
        [&](std::uint32_t) { is_there = true; });
    return is_there;
  }

  const MappedTin& mapped_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  PlaneLocator in_plane_;
  std::int32_t scale_;
  mutable std::once_flag has_lattice_;
  mutable Places nodes_;
  mutable std::optional<PlaneLocator> on_lattice_;
};

double rounded_up(long double error) {
  const auto near = static_cast<double>(error);
  return near < error ? std::nextafter(near, std::numeric_limits<double>::infinity()) : near;
}

}  // namespace

std::vector<std::array<std::uint32_t, 3>> turning_left_in_world(const delaunay::Tin& tin,
                                                                const HeightFrame& frame) {
  std::vector<std::array<std::uint32_t, 3>> triangles = tin.triangles;
  if (frame.is_mirrored())
    for (auto& triangle : triangles) std::swap(triangle[1], triangle[2]);
  return triangles;
}

Result<MappedErrors> measure_mapped(const MappedTin& mapped, const PlaceMap& map,
                                    const MeasuredSamples& samples, Threads threads,
                                    Progress& progress) {
  const SamplePieces pieces(samples, mapped);
  const MappedMeasure measure(mapped, pieces);
  struct Worker {
    std::unique_ptr<const PlaceMap> map;
    SamplePieces::Piece piece{};
    Places places{};
  };
  std::vector<Worker> workers;
  workers.reserve(static_cast<std::size_t>(n_workers(threads)));
  for (int i = 0; i < n_workers(threads); ++i) workers.push_back({.map = map.copy()});
  std::vector<PieceErrors> of_piece(pieces.size());
  std::atomic<std::size_t> n_done{0};
  parallel_for(of_piece.size(), threads, 1, [&](std::size_t i, int number) {
    if (progress.is_cancelled()) return;
    Worker& worker = workers[static_cast<std::size_t>(number)];
    pieces.fill(i, worker.piece);
    worker.places = worker.piece.world;
    worker.map->apply(worker.places);
    of_piece[i] = measure.look_at(worker.piece, worker.places);
    progress.report("measuring in the other CRS",
                    static_cast<double>(++n_done) / static_cast<double>(of_piece.size()));
  });
  if (progress.is_cancelled()) return cancelled_error();
  MappedErrors all;
  PieceErrors sum;
  for (const PieceErrors& one : of_piece) {
    if (one.error > sum.error || (sum.n_samples == 0 && one.n_samples > 0)) {
      sum.error = one.error;
      all.worst = one.worst;
    }
    sum.n_samples += one.n_samples;
    sum.n_without += one.n_without;
    if (sum.n_unmapped == 0) sum.unmapped = one.unmapped;
    sum.n_unmapped += one.n_unmapped;
  }
  if (sum.n_unmapped > 0)
    return fail(
        "expected samples that have places in the other CRS, got {} that have none, the "
        "first at {}, {}",
        sum.n_unmapped, sum.unmapped[0], sum.unmapped[1]);
  all.n_samples = sum.n_samples;
  all.n_without = sum.n_without;
  all.error = rounded_up(sum.error);
  return all;
}

}  // namespace lode
