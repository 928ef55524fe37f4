#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "lode/models/diamond/cell_rows.h"
#include "lode/models/diamond/cell_triangles.h"
#include "lode/models/diamond/edge_vertices.h"
#include "lode/models/diamond/gradient_rows.h"
#include "lode/models/diamond/normals.h"
#include "lode/models/diamond/row_edges.h"

namespace lode::diamond {

/// The vertices and triangles of the slices before one.
struct SliceBase {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
};

/// What the writers of all slices have in common.
struct FullSurface {
  const Model<3>& model;
  const LatticeFrame& frame;
  double isovalue;
  SurfaceStyle style;
  const SignField& signs;
  const RowStart* starts;            ///< By row, y fastest; from where its slice begins.
  std::span<const SliceBase> bases;  ///< By slice, and one behind the last.
  bool with_normals;
  Surface& surface;

  /// The rows of a slice, and one behind the last: behind all slices, where the surface ends.
  void place(std::int32_t z, std::vector<RowStart>& out) const {
    const auto slice = as_size(z);
    if (z == signs.dims[2]) {
      std::ranges::fill(out, start_of(bases[slice]));
      return;
    }
    const auto n_rows = as_size(signs.dims[1]);
    place_rows(starts + slice * n_rows, n_rows, start_of(bases[slice]), out.data());
    out.back() = start_of(bases[slice + 1]);
  }

 private:
  [[nodiscard]] static RowStart start_of(const SliceBase& base) {
    RowStart start;
    start.vertex.fill(static_cast<std::uint32_t>(base.vertices));
    start.triangle = static_cast<std::uint32_t>(base.triangles);
    return start;
  }
};

/// Writes the vertices and triangles of slices of cells, for which the surface has room and the
/// next slice is placed; one per worker.
class SliceWriter {
 public:
  SliceWriter() = default;
  SliceWriter(const SliceWriter&) = delete;
  SliceWriter& operator=(const SliceWriter&) = delete;
  virtual ~SliceWriter() = default;

  virtual void write(std::int32_t z) = 0;
  [[nodiscard]] const EdgeExtremes& extremes() const { return extremes_; }

 protected:
  EdgeExtremes extremes_;
};

/// T: the model's storage.
template <typename T>
class SliceWriterOf final : public SliceWriter {
 public:
  explicit SliceWriterOf(const FullSurface& all)
      : all_(all),
        frame_(NormalSampler<3, T>(all.model).frame()),
        gradients_(all.model),
        own_(as_size(all.signs.dims[1]) + 1),
        above_(own_.size()),
        groups_(all.signs) {
    const std::size_t n = n_most() + kEdgesPerRun + kEdgePadding;
    first_.resize(n);
    second_.resize(n);
    place_.resize(n);
    for (int parity = 0; parity < 8; ++parity)
      edges_[as_size(parity)] = &cell_edges(parity, all.frame.is_mirrored, all.style);
    if (!all.with_normals) return;
    kept_.resize(n);
    between_.resize(4 * n);
    first_place_.resize(n);
    second_place_.resize(n);
  }

  void write(std::int32_t z) override {
    if (z == placed_above_)
      std::swap(own_, above_);
    else
      all_.place(z, own_);
    all_.place(z + 1, above_);
    placed_above_ = z + 1;
    z_ = z;
    const RowStart& end = own_.back();
    positions_end_ = all_.surface.positions.data() + end.vertex[0];
    triangles_end_ = all_.surface.triangles.data() + end.triangle;
    run_.n = 0;
    found_y_ = -1;
    for (std::int32_t y = 0; y < all_.signs.dims[1]; ++y) write_row(y);
    write_vertices();
  }

 private:
  static constexpr std::uint32_t kAllSeries = (1U << kOwnSeries) - 1;
  /// Those along one axis, and body diagonals.
  static constexpr std::uint32_t kCubeSeries = 1U << 0 | 1U << 1 | 1U << 3 | 1U << 6;
  /// Beyond as many the vertices are written.
  static constexpr std::size_t kEdgesPerRun = 1024;

  /// Edges of a row.
  [[nodiscard]] std::size_t n_most() const { return kOwnSeries * as_size(all_.signs.dims[0]); }

  void write_row(std::int32_t y) {
    const RowStart* start = &own_[as_size(y)];
    const bool has_vertices = start[1].vertex[0] != start[0].vertex[0];
    const bool has_triangles = start[1].triangle != start[0].triangle;
    if (!has_vertices && !has_triangles) return;
    constexpr auto kRows = static_cast<std::int32_t>(SignField::kRows);
    if (const std::int32_t first = y / kRows * kRows; first != found_y_) {
      find_words(all_.signs, first, z_, all_.style, groups_);
      found_y_ = first;
    }
    const CellRow row(all_.signs, y, z_);
    const std::span<const WordGroup> groups = groups_.of_row(as_size(y % kRows));
    if (has_vertices) add_edges(y, groups);
    if (has_triangles) write_triangles(y, row, groups, start);
  }

  /// Adds the crossed edges of a row of anchors, direction by direction.
  void add_edges(std::int32_t y, std::span<const WordGroup> groups) {
    if (run_.n > kEdgesPerRun || (run_.n > 0 && y - y_ >= kRowsPerRun)) write_vertices();
    if (run_.n == 0) y_ = y;
    const Model<3>& model = all_.model;
    const std::int32_t brick_y = std::min(y / kBrickEdge<3>, model.brick_dims[1] - 1);
    const std::int32_t brick_z = std::min(z_ / kBrickEdge<3>, model.brick_dims[2] - 1);
    const Index<3> local{{0, y - brick_y * kBrickEdge<3>, z_ - brick_z * kBrickEdge<3>}};
    const std::byte* samples =
        model.brick(as_size(model.brick_dims[0]) *
                    (as_size(model.brick_dims[1]) * as_size(brick_z) + as_size(brick_y)));
    run_.n += gather_edges(
        AnchorRow<T>{groups, &edge_ends((y & 1) | (z_ & 1) << 1),
                     static_cast<std::uint32_t>(y - y_) << PackedEdge::kRowShift,
                     reinterpret_cast<const T*>(samples) + Model<3>::brick_offset(local),
                     as_size(model.brick_dims[0]), series_in(y)},
        EdgeLists<T>{first_.data() + run_.n, second_.data() + run_.n, place_.data() + run_.n});
    if (all_.with_normals) gradients_.find(y, z_, groups);
  }

  /// Of the directions with an axis.
  static constexpr std::uint32_t series_along(unsigned axis) {
    std::uint32_t series = 0;
    for (unsigned s = 0; s < kOwnSeries; ++s) series |= ((s + 1) >> axis & 1U) << s;
    return series;
  }
  /// Bits of the series that a row of anchors has edges of: none to rows and slices that are not
  /// there, whose samples would be read.
  [[nodiscard]] std::uint32_t series_in(std::int32_t y) const {
    std::uint32_t series = all_.style == SurfaceStyle::cubes ? kCubeSeries : kAllSeries;
    if (y + 1 == all_.signs.dims[1]) series &= ~series_along(1);
    if (z_ + 1 == all_.signs.dims[2]) series &= ~series_along(2);
    return series;
  }

  /// Those on the edges that were added since the last ones.
  void write_vertices() {
    if (run_.n == 0) return;
    run_.first = first_.data();
    run_.second = second_.data();
    run_.place = place_.data();
    const std::size_t first = own_[as_size(y_)].vertex[0];
    Surface& surface = all_.surface;
    place_vertices(run_,
                   {&all_.frame, all_.isovalue, y_, z_, surface.positions.data() + first,
                    positions_end_, all_.with_normals ? kept_.data() : nullptr},
                   extremes_);
    if (all_.with_normals) write_normals(first);
    run_.n = 0;
  }

  /// Of the run's vertices, from the surface's `first` on.
  void write_normals(std::size_t first) {
    find_places(gradients_.places(),
                {place_.data(), run_.n, y_, z_, first_place_.data(), second_place_.data()});
    std::vector<Vec3f>& normals = all_.surface.normals;
    const auto n_before = positions_end_ - all_.surface.positions.data();
    place_normals(
        EdgeGradients<GradientOf<T>>{gradients_.gradients(), first_place_.data(),
                                     second_place_.data(), kept_.data(), run_.n, between_.data()},
        frame_, normals.data() + first, normals.data() + n_before);
  }

  void write_triangles(std::int32_t y, const CellRow& row, std::span<const WordGroup> groups,
                       const RowStart* start) {
    const std::size_t parity = as_size(y & 1) << 1 | as_size(z_ & 1) << 2;
    write_cells({&row, groups, start, &above_[as_size(y)], all_.style, edges_[parity],
                 edges_[parity | 1], all_.surface.triangles[start->triangle].data(),
                 triangles_end_->data()});
  }

  const FullSurface& all_;
  NormalFrame frame_;
  GradientRows<T> gradients_;
  std::vector<RowStart> own_, above_;  ///< Of the slice, and of the next one.
  std::int32_t placed_above_ = -1;
  std::int32_t z_ = 0;
  std::int32_t y_ = 0;  ///< Of the first row that the run has edges of.
  const Vec3f* positions_end_ = nullptr;
  const std::array<std::uint32_t, 3>* triangles_end_ = nullptr;
  RowGroups groups_;           ///< Of rows from found_y_ on.
  std::int32_t found_y_ = -1;  ///< None: < 0.
  std::vector<T> first_, second_;
  std::vector<std::uint32_t> place_;
  std::vector<double> kept_;
  std::vector<std::uint32_t> first_place_, second_place_;  ///< The ends, as gradients_ has them.
  std::vector<double> between_;
  std::array<const CellEdges*, 8> edges_{};  ///< Of cells, by parity.
  EdgeRun<T> run_{};
};

}  // namespace lode::diamond
