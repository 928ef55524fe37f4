#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "lode/models/diamond/cell_rows.h"
#include "lode/models/diamond/cell_triangles.h"
#include "lode/models/diamond/edge_vertices.h"
#include "lode/models/diamond/normals.h"
#include "lode/models/diamond/row_edges.h"

namespace lode::diamond {

/// First vertex of each own series of a row, and its first triangle.
struct RowStart {
  std::array<std::uint32_t, kOwnSeries> vertex{};
  std::uint32_t triangle = 0;
};

/// What the writers of all slices have in common.
struct FullSurface {
  const Model<3>& model;
  const LatticeFrame& frame;
  double isovalue;
  const SignField& signs;
  std::span<const RowStart> starts;  ///< By row, y fastest, and one behind the last.
  Surface& surface;                  ///< Has room for all; normals only where they are wanted.

  [[nodiscard]] std::size_t row_of(std::int32_t y, std::int32_t z) const {
    return as_size(z) * as_size(signs.dims[1]) + as_size(y);
  }
};

/// Writes the vertices and triangles of slices of cells; one per worker. T: the model's storage.
template <typename T>
class SliceWriter {
 public:
  explicit SliceWriter(const FullSurface& all)
      : all_(all), sampler_(all.model), words_(all.signs.n_words()) {
    const std::size_t n = n_most() + kEdgesPerRun + kEdgePadding;
    first_.resize(n);
    second_.resize(n);
    place_.resize(n);
    edge_words_.resize(kOwnSeries * words_.size() + 1);
    if (!all.surface.normals.empty()) kept_.resize(n);
  }

  void write(std::int32_t z) {
    z_ = z;
    const RowStart& next = all_.starts[all_.row_of(0, z + 1)];
    positions_end_ = all_.surface.positions.data() + next.vertex[0];
    triangles_end_ = all_.surface.triangles.data() + next.triangle;
    run_.n = 0;
    for (std::int32_t y = 0; y < all_.signs.dims[1]; ++y) write_row(y);
    write_vertices();
  }
  [[nodiscard]] const EdgeExtremes& extremes() const { return extremes_; }

 private:
  /// Beyond as many the vertices are written.
  static constexpr std::size_t kEdgesPerRun = 1024;

  /// Edges of a row.
  [[nodiscard]] std::size_t n_most() const { return kOwnSeries * as_size(all_.signs.dims[0]); }

  void write_row(std::int32_t y) {
    const RowStart* start = &all_.starts[all_.row_of(y, z_)];
    const bool has_vertices = start[1].vertex[0] != start[0].vertex[0];
    const bool has_triangles = start[1].triangle != start[0].triangle;
    if (!has_vertices && !has_triangles) return;
    const CellRow row(all_.signs, y, z_);
    const std::span<const WordCells> words =
        std::span(words_).first(find_words(row, words_.data()));
    if (has_vertices) add_edges(y, words);
    if (has_triangles) write_triangles(y, row, words, start->triangle);
  }

  /// Adds the crossed edges of a row of anchors, direction by direction.
  void add_edges(std::int32_t y, std::span<const WordCells> words) {
    if (run_.n > kEdgesPerRun || (run_.n > 0 && y - y_ >= kRowsPerRun)) write_vertices();
    if (run_.n == 0) y_ = y;
    const std::size_t n = find_edge_words(y, words);
    run_.n += gather_edges(
        std::span<const EdgeWord<T>>(edge_words_).first(n),
        EdgeLists<T>{first_.data() + run_.n, second_.data() + run_.n, place_.data() + run_.n});
  }

  std::size_t find_edge_words(std::int32_t y, std::span<const WordCells> words) {
    const Model<3>& model = all_.model;
    Index<3> brick;
    Index<3> local{{0, y, z_}};
    for (std::size_t i = 1; i < 3; ++i) {
      brick[i] = std::min(local[i] / kBrickEdge<3>, model.brick_dims[i] - 1);
      local[i] -= brick[i] * kBrickEdge<3>;
    }
    const T* first =
        reinterpret_cast<const T*>(model.brick(linear_index<3>(model.brick_dims, brick))) +
        Model<3>::brick_offset(local);
    const EdgeEndsByDirection& ends = edge_ends((y & 1) | (z_ & 1) << 1);
    const auto n_bricks = as_size(model.brick_dims[0]);
    const std::uint32_t row = static_cast<std::uint32_t>(y - y_) << kRowShift;
    std::size_t n = 0;
    for (std::size_t s = 0; s < kOwnSeries; ++s)
      for (const WordCells& w : words) {
        const bool is_last = w.word == n_bricks;  // the border of the last brick
        const T* samples = is_last ? first + (w.word - 1) * kBrickSize<3> + kBrickEdge<3>
                                   : first + w.word * kBrickSize<3>;
        edge_words_[n] = {samples, &ends[s], row + static_cast<std::uint32_t>(w.word) * 32,
                          w.crossings[s], is_last};
        n += w.crossings[s] != 0 ? 1 : 0;
      }
    return n;
  }

  /// Those on the edges that were added since the last ones.
  void write_vertices() {
    if (run_.n == 0) return;
    run_.first = first_.data();
    run_.second = second_.data();
    run_.place = place_.data();
    const std::size_t first = all_.starts[all_.row_of(y_, z_)].vertex[0];
    Surface& surface = all_.surface;
    const bool with_normals = !surface.normals.empty();
    place_vertices(run_,
                   {&all_.frame, all_.isovalue, y_, z_, surface.positions.data() + first,
                    positions_end_, with_normals ? kept_.data() : nullptr},
                   extremes_);
    for (std::size_t i = 0; with_normals && i < run_.n; ++i) {
      const auto [p, q] = unpacked_edge(place_[i], y_, z_);
      surface.normals[first + i] = sampler_.at({to_key(p), to_key(q), kept_[i]});
    }
    run_.n = 0;
  }

  /// A series of a row of cells: whose row it is, by y + 2 z, and which of that one's own.
  struct SeriesPlace {
    std::uint8_t row = 0;
    std::uint8_t own = 0;
  };
  static constexpr std::array<SeriesPlace, kEdgeSeries> kPlaces = [] {
    std::array<SeriesPlace, kEdgeSeries> places{};
    for (int row = 0; row < 4; ++row)
      for (int direction = 1; direction < 8; ++direction) {
        const int row_y = row & 1;
        const int row_z = row >> 1;
        if (((direction >> 1 & 1) & row_y) != 0 || ((direction >> 2 & 1) & row_z) != 0) continue;
        places[static_cast<std::size_t>(edge_series(direction, row_y, row_z))] = {
            static_cast<std::uint8_t>(row), static_cast<std::uint8_t>(direction - 1)};
      }
    return places;
  }();

  /// The numbers of the first vertex of all series that a row of cells touches.
  [[nodiscard]] PerSeries first_ids(std::int32_t y) const {
    const RowStart* start = &all_.starts[all_.row_of(y, z_)];
    const RowStart* above = &all_.starts[all_.row_of(y, z_ + 1)];
    const std::array<const RowStart*, 4> rows{start, start + 1, above, above + 1};
    PerSeries ids{};
    for (std::size_t s = 0; s < kPlaces.size(); ++s)
      ids[s] = rows[kPlaces[s].row]->vertex[kPlaces[s].own];
    return ids;
  }

  void write_triangles(std::int32_t y, const CellRow& row, std::span<const WordCells> words,
                       std::size_t first) {
    const int parity = (y & 1) << 1 | (z_ & 1) << 2;
    const PerSeries first_id = first_ids(y);
    write_cells({&row, words, &first_id, &cell_edges(parity, all_.frame.is_mirrored),
                 &cell_edges(parity | 1, all_.frame.is_mirrored),
                 all_.surface.triangles[first].data(), triangles_end_->data()});
  }

  const FullSurface& all_;
  NormalSampler<3, T> sampler_;
  std::int32_t z_ = 0;
  std::int32_t y_ = 0;  ///< Of the first row that the run has edges of.
  const Vec3f* positions_end_ = nullptr;
  const std::array<std::uint32_t, 3>* triangles_end_ = nullptr;
  std::vector<WordCells> words_;  ///< Those of a row that the surface meets.
  std::vector<EdgeWord<T>> edge_words_;
  std::vector<T> first_, second_;
  std::vector<std::uint32_t> place_;
  std::vector<double> kept_;
  EdgeRun<T> run_{};
  EdgeExtremes extremes_;
};

}  // namespace lode::diamond
