#include "lode/delaunay/seams.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lode/delaunay/line_splitter.h"

namespace lode::delaunay {
namespace {

/// Splits what lies between two nodes of a row or of a column.
template <typename T>
class SideSplitter {
 public:
  SideSplitter(const SampleRows<T>& rows, const GridCells* cells, const SeamOptions& options)
      : rows_(rows),
        cells_(cells),
        turn_(options.turn),
        splitter_(options.range, options.max_error) {}

  SeamSide split(const LatticePart& part) {
    const bool is_row = part.first.y == part.last.y;
    const std::int32_t start = is_row ? part.first.x : part.first.y;
    const std::int32_t n = (is_row ? part.last.x : part.last.y) - start;
    const T* from = rows_.samples + part.first.y * rows_.stride + part.first.x;
    line_.resize(static_cast<std::size_t>(n) + 1);
    for (std::int32_t i = 0; i <= n; ++i)
      line_[static_cast<std::size_t>(i)] = from[i * (is_row ? 1 : rows_.stride)];
    SeamSide side;
    int before = 0;
    std::int32_t first = 0;
    // One step more ends the last run.
    for (std::int32_t i = 0; i <= n; ++i) {
      const int now = i < n ? beside(part.first, is_row, i) : 0;
      if (now == before) continue;
      if (before != 0)
        side.error = std::max(side.error, splitter_.split(line_.data(), first, i, side.places));
      side.places.push_back(i);
      before = now;
      first = i;
    }
    for (std::int32_t& place : side.places) place += start;
    return side;
  }

 private:
  /// On which sides there are cells at a step, in two bits.
  [[nodiscard]] int beside(LatticePoint first, bool is_row, std::int32_t step) const {
    if (cells_ == nullptr) return 1;
    const LatticePoint p{first.x + (is_row ? step : 0), first.y + (is_row ? 0 : step)};
    if (is_row) return int{cells_->has(p.x, p.y)} + 2 * int{cells_->has(p.x, p.y - 1)};
    const bool is_right = cells_->has(p.x == turn_ ? 0 : p.x, p.y);
    const bool is_left = cells_->has((p.x == 0 ? turn_ : p.x) - 1, p.y);
    return int{is_right} + 2 * int{is_left};
  }

  const SampleRows<T>& rows_;
  const GridCells* cells_;
  std::int32_t turn_;
  LineSplitter<T> splitter_;
  std::vector<T> line_;
};

}  // namespace

Seams::Seams(const TileLayout& layout)
    : layout_(layout),
      n_along_rows_(layout.n_across() * layout.rows().size()),
      sides_(n_along_rows_ + layout.columns().size() * (layout.rows().size() - 1)) {}

LatticePart Seams::part(std::size_t side) const {
  const auto& columns = layout_.columns();
  const auto& rows = layout_.rows();
  if (side < n_along_rows_) {
    const std::size_t i = side % layout_.n_across();
    const std::int32_t y = rows[side / layout_.n_across()];
    return {{columns[i], y}, {columns[i + 1], y}};
  }
  const std::size_t i = (side - n_along_rows_) % columns.size();
  const std::size_t j = (side - n_along_rows_) / columns.size();
  return {{columns[i], rows[j]}, {columns[i], rows[j + 1]}};
}

template <typename T>
Seams find_seams(const TileLayout& layout, const SampleRows<T>& rows, const GridCells* cells,
                 const SeamOptions& options) {
  Seams seams(layout);
  std::vector<SideSplitter<T>> splitters(static_cast<std::size_t>(n_workers(options.threads)),
                                         SideSplitter<T>(rows, cells, options));
  parallel_for(seams.n_sides(), options.threads, 1, [&](std::size_t i, int worker) {
    seams.side(i) = splitters[static_cast<std::size_t>(worker)].split(seams.part(i));
  });
  return seams;
}

template <typename T>
std::vector<std::int32_t> find_round_side(LatticePoint last, const SampleRows<T>& rows,
                                          const GridCells* cells, const SeamOptions& options) {
  return SideSplitter<T>(rows, cells, options).split({{0, 0}, {0, last.y}}).places;
}

template <typename T>
std::int32_t choose_tile_side(LatticePoint last, const SampleRows<T>& rows, const GridCells* cells,
                              const SeamOptions& options) {
  constexpr std::int32_t kLines = 16;  // Each way.
  // Of 4096^2 samples of a sum of three sines half as many cost 2 to 8 % more triangles than the
  // strict order, as many none; of a fractal even fewer do not matter.
  constexpr double kVerticesPerSide = 12;
  // A mesh of all samples of the smallest stays in the cache, and larger ones take as long.
  constexpr double kLeastSide = 128;
  constexpr double kLargestSide = 2048;
  SideSplitter<T> splitter(rows, cells, options);
  double n_steps = 0;
  double n_vertices = 0;
  const auto look = [&](const LatticePart& part) {
    const SeamSide side = splitter.split(part);
    if (side.places.empty()) return;
    n_steps += side.places.back() - side.places.front();
    n_vertices += static_cast<double>(side.places.size() - 1);
  };
  for (std::int32_t i = 0; i < kLines; ++i) {
    const auto at = [&](std::int64_t n) {
      return static_cast<std::int32_t>((n * (2 * i + 1)) / (2 * kLines));
    };
    look({{0, at(last.y)}, {last.x, at(last.y)}});
    look({{at(last.x), 0}, {at(last.x), last.y}});
  }
  if (n_vertices == 0) return static_cast<std::int32_t>(kLargestSide);
  return static_cast<std::int32_t>(
      std::clamp(kVerticesPerSide * n_steps / n_vertices, kLeastSide, kLargestSide));
}

template Seams find_seams(const TileLayout&, const SampleRows<std::int16_t>&, const GridCells*,
                          const SeamOptions&);
template Seams find_seams(const TileLayout&, const SampleRows<std::uint16_t>&, const GridCells*,
                          const SeamOptions&);
template Seams find_seams(const TileLayout&, const SampleRows<float>&, const GridCells*,
                          const SeamOptions&);
template Seams find_seams(const TileLayout&, const SampleRows<double>&, const GridCells*,
                          const SeamOptions&);
template std::vector<std::int32_t> find_round_side(LatticePoint, const SampleRows<std::int16_t>&,
                                                   const GridCells*, const SeamOptions&);
template std::vector<std::int32_t> find_round_side(LatticePoint, const SampleRows<std::uint16_t>&,
                                                   const GridCells*, const SeamOptions&);
template std::vector<std::int32_t> find_round_side(LatticePoint, const SampleRows<float>&,
                                                   const GridCells*, const SeamOptions&);
template std::vector<std::int32_t> find_round_side(LatticePoint, const SampleRows<double>&,
                                                   const GridCells*, const SeamOptions&);
template std::int32_t choose_tile_side(LatticePoint, const SampleRows<std::int16_t>&,
                                       const GridCells*, const SeamOptions&);
template std::int32_t choose_tile_side(LatticePoint, const SampleRows<std::uint16_t>&,
                                       const GridCells*, const SeamOptions&);
template std::int32_t choose_tile_side(LatticePoint, const SampleRows<float>&, const GridCells*,
                                       const SeamOptions&);
template std::int32_t choose_tile_side(LatticePoint, const SampleRows<double>&, const GridCells*,
                                       const SeamOptions&);

}  // namespace lode::delaunay
