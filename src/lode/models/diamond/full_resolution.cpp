#include "lode/models/diamond/full_resolution.h"

#include <chrono>
#include <cmath>
#include <limits>

#include "lode/mappers/kuhn_cube.h"
#include "lode/models/diamond/cell_rows.h"
#include "lode/models/diamond/normals.h"

namespace lode::diamond {
namespace {

using Counters = std::array<std::uint32_t, kEdgeSeries>;
/// Series in the cell row's own row of anchors; the others belong to neighbouring rows.
constexpr std::size_t kOwnSeries = 7;

/// Direction (a set of axes) of each series in the first row; see edge_series().
constexpr std::array<unsigned, kOwnSeries> kDirection{1, 2, 3, 4, 5, 6, 7};

/// First vertex of each own series of a row, and its first triangle.
struct RowStart {
  std::array<std::uint32_t, kOwnSeries> vertex{};
  std::uint32_t triangle = 0;
};

struct Extremes {
  double largest_step = 0;
  double largest_snap = 0;
};

/// Writes the vertices on one word's crossed edges.
template <typename T>
class VertexWriter {
 public:
  /// Normals are written where there is room for them.
  VertexWriter(const Model<3>& model, const LatticeFrame& frame, double isovalue, Surface& surface)
      : model_(model),
        frame_(frame),
        sampler_(model),
        isovalue_(isovalue),
        positions_(surface.positions.data()),
        normals_(surface.normals.empty() ? nullptr : surface.normals.data()) {}

  /// Sets the row of anchors (y, z), then 32 of them.
  void open_row(std::int32_t y, std::int32_t z) {
    anchor_ = {{0, y, z}};
    for (std::size_t i = 1; i < 3; ++i)
      brick_[i] = std::min(anchor_[i] / kBrickEdge<3>, model_.brick_dims[i] - 1);
    const unsigned parity = (static_cast<unsigned>(y) & 1) << 1 | (static_cast<unsigned>(z) & 1)
                                                                      << 2;
    for (unsigned direction = 1; direction < 8; ++direction)
      ends_[direction] = {ends_of(direction, parity), ends_of(direction, parity | 1)};
  }
  void open_word(std::size_t word) {
    brick_[0] = std::min(static_cast<std::int32_t>(word), model_.brick_dims[0] - 1);
    anchor_[0] = static_cast<std::int32_t>(word) * 32;
    samples_ =
        reinterpret_cast<const T*>(model_.brick(linear_index<3>(model_.brick_dims, brick_))) +
        Model<3>::brick_offset(anchor_ - brick_ * kBrickEdge<3>);
  }

  /// The crossed edges of one direction; the first gets this number.
  void write(unsigned direction, std::uint32_t crossed, std::uint32_t id) {
    const std::array<EdgeEnds, 2>& ends = ends_[direction];
    for (; crossed != 0; crossed &= crossed - 1, ++id) {
      const int x = std::countr_zero(crossed);
      write_one(samples_ + x, anchor_[0] + x, ends[as_size(x & 1)], id);
    }
  }
  [[nodiscard]] const Extremes& extremes() const { return extremes_; }

 private:
  struct EdgeEnds {
    Index<3> first, second;  ///< Offsets from the anchor; the first has the smaller key.
    std::size_t first_sample, second_sample;
  };

  /// An edge joins the corners of its box whose coordinates are even, and odd, along its axes.
  [[nodiscard]] static EdgeEnds ends_of(unsigned direction, unsigned parity) {
    const int last_axis = 31 - std::countl_zero(direction);
    const unsigned same = ((parity >> last_axis) & 1) != 0 ? ~parity : parity;
    EdgeEnds ends{};
    for (std::size_t i = 0; i < 3; ++i) {
      ends.first[i] = static_cast<std::int32_t>((direction & same) >> i & 1);
      ends.second[i] = static_cast<std::int32_t>((direction & ~same) >> i & 1);
    }
    ends.first_sample = Model<3>::brick_offset(ends.first);
    ends.second_sample = Model<3>::brick_offset(ends.second);
    return ends;
  }

  void write_one(const T* anchor, std::int32_t x, const EdgeEnds& ends, std::uint32_t id) {
    const auto a = static_cast<double>(anchor[ends.first_sample]);
    const auto b = static_cast<double>(anchor[ends.second_sample]);
    const double step = std::abs(b - a);
    const double t = (isovalue_ - a) / (b - a);
    const double kept = std::clamp(t, frame_.margin, 1 - frame_.margin);
    extremes_.largest_step = std::max(extremes_.largest_step, step);
    if (kept != t) extremes_.largest_snap = std::max(extremes_.largest_snap, step);
    const Index<3> anchor_point{{x, anchor_[1], anchor_[2]}};
    const Index<3> p = anchor_point + ends.first;
    const Index<3> q = anchor_point + ends.second;
    Vec3d lattice;
    for (std::size_t i = 0; i < 3; ++i) lattice[i] = p[i] + kept * (q[i] - p[i]);
    const Vec3d world = frame_.position(lattice);
    positions_[id] = {
        {static_cast<float>(world[0]), static_cast<float>(world[1]), static_cast<float>(world[2])}};
    if (normals_ != nullptr) normals_[id] = sampler_.at({to_key(p), to_key(q), kept});
  }

  const Model<3>& model_;
  const LatticeFrame& frame_;
  NormalSampler<3, T> sampler_;
  double isovalue_;
  Vec3f* positions_;
  Vec3f* normals_;
  Index<3> anchor_;  ///< The word's first.
  Index<3> brick_;
  const T* samples_ = nullptr;                     ///< At that anchor.
  std::array<std::array<EdgeEnds, 2>, 8> ends_{};  ///< By direction and parity of x.
  Extremes extremes_;
};

/// What the triangles of one word of cells are made from.
struct WordCells {
  CornerRows corners;
  std::uint32_t crossed;
  Counters crossings;  ///< Per series, crossed anchors (bits).
  Counters first_id;   ///< Per series, the id of the first of them.
};

/// Appends the triangles of the word's crossed cells at `out`; returns its end.
std::array<std::uint32_t, 3>* write_cells(const WordCells& w, const KuhnCubeCases& even_x,
                                          const KuhnCubeCases& odd_x,
                                          std::array<std::uint32_t, 3>* out) {
  for (std::uint32_t cells = w.crossed; cells != 0; cells &= cells - 1) {
    const int x = std::countr_zero(cells);
    const std::size_t corners = (w.corners[0] >> x & 3) | (w.corners[1] >> x & 3) << 2 |
                                (w.corners[2] >> x & 3) << 4 | (w.corners[3] >> x & 3) << 6;
    const KuhnCubeCase& c = ((x & 1) != 0 ? odd_x : even_x)[corners];
    std::array<std::uint32_t, 19> id;
    for (std::size_t e = 0; e < c.n_edges; ++e) {
      const std::size_t series = c.edges[e] & 15;
      const std::uint64_t before = (std::uint64_t{1} << (x + (c.edges[e] >> 4))) - 1;
      id[e] = w.first_id[series] +
              static_cast<std::uint32_t>(std::popcount(w.crossings[series] & before));
    }
    for (std::size_t t = 0; t < c.n_triangles; ++t)
      *out++ = {id[c.triangles[t][0]], id[c.triangles[t][1]], id[c.triangles[t][2]]};
  }
  return out;
}

class FullResolution {
 public:
  FullResolution(const Selection<3>& selection, const LatticeFrame& frame,
                 const IsosurfaceQuery& query, Surface& surface, Progress& progress)
      : selection_(selection),
        model_(selection.model()),
        frame_(frame),
        query_(query),
        surface_(surface),
        progress_(progress) {}

  Result<FullResolutionReport> run() {
    const auto start = std::chrono::steady_clock::now();
    field_ = sign_field(selection_, query_.threads, report_.n_bricks_read);
    for_each_slice([&](std::int32_t y, std::int32_t z) { count(y, z); });
    LODE_CHECK(place());
    const auto counted = std::chrono::steady_clock::now();
    std::vector<Extremes> extremes(as_size(model_.shape.dims[2]));
    visit_storage_type(model_.storage, [&]<typename T>() { write<T>(extremes); });
    if (progress_.is_cancelled()) return cancelled_error();
    for (const Extremes& e : extremes) {
      report_.largest_step = std::max(report_.largest_step, e.largest_step);
      report_.largest_snap = std::max(report_.largest_snap, e.largest_snap);
    }
    const auto done = std::chrono::steady_clock::now();
    report_.sign_seconds = std::chrono::duration<double>(counted - start).count();
    report_.write_seconds = std::chrono::duration<double>(done - counted).count();
    return report_;
  }

 private:
  [[nodiscard]] std::size_t row_of(std::int32_t y, std::int32_t z) const {
    return as_size(z) * as_size(field_.dims[1]) + as_size(y);
  }

  template <typename F>
  void for_each_slice(const F& body) {
    starts_.resize(as_size(field_.dims[1]) * as_size(field_.dims[2]));
    parallel_for(as_size(field_.dims[2]), query_.threads, 1, [&](std::size_t z, int) {
      if (progress_.is_cancelled()) return;
      for (std::int32_t y = 0; y < field_.dims[1]; ++y) body(y, static_cast<std::int32_t>(z));
    });
  }

  void count(std::int32_t y, std::int32_t z) {
    const CellRow row(field_, y, z);
    RowStart n;
    Counters crossings;
    for (std::size_t word = 0; word < field_.n_words(); ++word) {
      const CornerRows r = row.corners(word);
      if (CellRow::is_uniform(r)) continue;
      row.crossings(r, word, crossings);
      for (std::size_t s = 0; s < kOwnSeries; ++s)
        n.vertex[s] += static_cast<std::uint32_t>(std::popcount(crossings[s]));
      if (row.has_cells()) n.triangle += row.n_triangles(r, word);
    }
    starts_[row_of(y, z)] = n;
  }

  /// Turns counts into first numbers and makes room.
  Result<void> place() {
    std::uint64_t n_vertices = query_.replaces ? 0 : surface_.positions.size();
    std::uint64_t n_triangles = query_.replaces ? 0 : surface_.triangles.size();
    for (RowStart& start : starts_) {
      for (std::uint32_t& first : start.vertex) {
        const std::uint32_t n = first;
        first = static_cast<std::uint32_t>(n_vertices);
        n_vertices += n;
      }
      const std::uint32_t n = start.triangle;
      start.triangle = static_cast<std::uint32_t>(n_triangles);
      n_triangles += n;
    }
    if (std::max(n_vertices, n_triangles) > std::numeric_limits<std::uint32_t>::max())
      return fail("the surface has {} vertices and {} triangles, more than {}: give it a tolerance",
                  n_vertices, n_triangles, std::numeric_limits<std::uint32_t>::max());
    if (query_.replaces) surface_.lines.clear();
    surface_.positions.resize(n_vertices);
    surface_.triangles.resize(n_triangles);
    surface_.normals.resize(query_.with_normals ? n_vertices : 0);
    return {};
  }

  template <typename T>
  void write(std::vector<Extremes>& extremes) {
    parallel_for(as_size(field_.dims[2]), query_.threads, 1, [&](std::size_t z, int) {
      if (progress_.is_cancelled()) return;
      VertexWriter<T> vertices(model_, frame_, selection_.isovalue(), surface_);
      for (std::int32_t y = 0; y < field_.dims[1]; ++y)
        write_row(y, static_cast<std::int32_t>(z), vertices);
      extremes[z] = vertices.extremes();
    });
  }

  /// The numbers of the first vertex of all series a row of cells touches.
  [[nodiscard]] Counters first_ids(std::int32_t y, std::int32_t z, const CellRow& row) const {
    Counters ids{};
    for (std::size_t s = 0; s < kOwnSeries; ++s) ids[s] = starts_[row_of(y, z)].vertex[s];
    for (int direction = 1; direction < 8; ++direction)
      for (int i = 1; i < 4; ++i) {
        const int row_y = i & 1;
        const int row_z = i >> 1;
        if (((direction >> 1 & 1) & row_y) != 0 || ((direction >> 2 & 1) & row_z) != 0) continue;
        if (!row.has_row(row_y, row_z)) continue;
        ids[as_size(edge_series(direction, row_y, row_z))] =
            starts_[row_of(y + row_y, z + row_z)].vertex[as_size(direction - 1)];
      }
    return ids;
  }

  template <typename T>
  void write_row(std::int32_t y, std::int32_t z, VertexWriter<T>& vertices) {
    const CellRow row(field_, y, z);
    const int parity = (y & 1) << 1 | (z & 1) << 2;
    const KuhnCubeCases& even_x = kuhn_cube_cases(parity, frame_.is_mirrored);
    const KuhnCubeCases& odd_x = kuhn_cube_cases(parity | 1, frame_.is_mirrored);
    WordCells cells;
    cells.first_id = first_ids(y, z, row);
    auto* out = surface_.triangles.data() + starts_[row_of(y, z)].triangle;
    vertices.open_row(y, z);
    for (std::size_t word = 0; word < field_.n_words(); ++word) {
      cells.corners = row.corners(word);
      if (CellRow::is_uniform(cells.corners)) continue;
      row.crossings(cells.corners, word, cells.crossings);
      vertices.open_word(word);
      for (std::size_t s = 0; s < kOwnSeries; ++s)
        vertices.write(kDirection[s], cells.crossings[s], cells.first_id[s]);
      cells.crossed = row.has_cells() ? row.crossed_cells(cells.corners, word) : 0;
      out = write_cells(cells, even_x, odd_x, out);
      for (std::size_t s = 0; s < kEdgeSeries; ++s)
        cells.first_id[s] += static_cast<std::uint32_t>(std::popcount(cells.crossings[s]));
    }
  }

  const Selection<3>& selection_;
  const Model<3>& model_;
  const LatticeFrame& frame_;
  const IsosurfaceQuery& query_;
  Surface& surface_;
  Progress& progress_;
  SignField field_;
  std::vector<RowStart> starts_;
  FullResolutionReport report_;
};

}  // namespace

Result<FullResolutionReport> extract_full_resolution(const Selection<3>& selection,
                                                     const LatticeFrame& frame,
                                                     const IsosurfaceQuery& query, Surface& surface,
                                                     Progress& progress) {
  surface.origin = frame.surface_origin;
  return FullResolution(selection, frame, query, surface, progress).run();
}

}  // namespace lode::diamond
