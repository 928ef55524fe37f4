#include "lode/api/volume_integral.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "lode/api/file_build.h"
#include "lode/api/probe_cells.h"
#include "lode/api/probe_integrator.h"
#include "lode/models/diamond/file_samples.h"
#include "lode/models/diamond/sample_rows.h"

namespace lode {
namespace {

using diamond::Index;
using diamond::LatticeBox;
using diamond::Model;
using probe_sums::CellIntegrator;
using probe_sums::IntegralCell;
using probe_sums::PartialIntegral;

/// Unit cells, by their lowest corners, per edge of what is read at once.
constexpr std::int32_t kEdge = 128;
/// Finest tetrahedra of a unit cell.
constexpr std::uint64_t kPerCell = 6;

/// Unit cells of a row: first <= x < last.
struct CellSpan {
  std::int32_t first = 0;
  std::int32_t last = 0;

  [[nodiscard]] std::int32_t size() const { return std::max(0, last - first); }
};

/// Where unit cells are, as seen from a box in the world. Rounding may take cells that touch it, or
/// a little more, for ones that meet it and are not inside.
class CellPlaces {
 public:
  CellPlaces(const RegularGrid& grid, const std::optional<Box3d>& box)
      : box_(box), origin_(grid.origin), matrix_(grid.index_to_world_matrix()) {
    for (std::size_t a = 0; a < 3; ++a) {
      double reach = std::abs(origin_[a]);
      for (std::size_t i = 0; i < 3; ++i) {
        reach += std::abs(matrix_.rows[a][i]) * grid.dims[i];
        below_[a] += std::min(0.0, matrix_.rows[a][i]);
        above_[a] += std::max(0.0, matrix_.rows[a][i]);
      }
      slack_[a] = 0x1p-40 * reach;
    }
  }

  /// The cells of a row that are in the box, for certain.
  [[nodiscard]] CellSpan inside(std::int32_t y, std::int32_t z, CellSpan row) const {
    for (std::size_t a = 0; box_ && a < 3; ++a) {
      const double at = at_row(a, y, z);
      keep(matrix_.rows[a][0], at + below_[a] - slack_[a] - box_->lower[a], row);
      keep(-matrix_.rows[a][0], box_->upper[a] - at - above_[a] - slack_[a], row);
    }
    return row;
  }
  /// All others are outside, for certain.
  [[nodiscard]] CellSpan meeting(std::int32_t y, std::int32_t z, CellSpan row) const {
    for (std::size_t a = 0; box_ && a < 3; ++a) {
      const double at = at_row(a, y, z);
      keep(matrix_.rows[a][0], at + above_[a] + slack_[a] - box_->lower[a], row);
      keep(-matrix_.rows[a][0], box_->upper[a] - at - below_[a] + slack_[a], row);
    }
    return row;
  }

 private:
  [[nodiscard]] double at_row(std::size_t a, std::int32_t y, std::int32_t z) const {
    return origin_[a] + matrix_.rows[a][1] * y + matrix_.rows[a][2] * z;
  }
  /// Those with slope * x + offset >= 0.
  static void keep(double slope, double offset, CellSpan& row) {
    if (slope == 0) {
      if (offset < 0) row.last = row.first;
      return;
    }
    const double at = std::clamp(-offset / slope, -1.0, 0x1p30);
    if (slope > 0)
      row.first = std::max(row.first, static_cast<std::int32_t>(std::ceil(at)));
    else
      row.last = std::min(row.last, static_cast<std::int32_t>(std::floor(at)) + 1);
  }

  std::optional<Box3d> box_;
  Vec3d origin_;
  Mat3 matrix_;
  Vec3d below_{};  ///< Of a cell's corners, from its lowest one, the farthest along each axis,
  Vec3d above_{};  ///< either way.
  Vec3d slack_{};
};

/// The unit cells that may meet a box: lower <= cell < upper.
LatticeBox<3> cells_round(const RegularGrid& grid, const std::optional<Box3d>& box) {
  LatticeBox<3> cells{{}, grid.dims - Index3{{1, 1, 1}}};
  if (!box) return cells;
  Vec3d low{{0x1p30, 0x1p30, 0x1p30}};
  Vec3d high = low * -1.0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    Vec3d p;
    for (std::size_t i = 0; i < 3; ++i)
      p[i] = (corner >> i & 1U) != 0 ? box->upper[i] : box->lower[i];
    const Vec3d index = grid.to_index(p);
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], index[i]);
      high[i] = std::max(high[i], index[i]);
    }
  }
  constexpr double kReach = 2;  // those that touch it, and rounding
  for (std::size_t i = 0; i < 3; ++i) {
    const double most = cells.upper[i];
    cells.lower[i] = static_cast<std::int32_t>(std::clamp(std::floor(low[i]) - kReach, 0.0, most));
    cells.upper[i] = static_cast<std::int32_t>(std::clamp(std::ceil(high[i]) + kReach, 0.0, most));
  }
  return cells;
}

/// What the samples of a row's cells add up to. The integral over a cell is its volume times a
/// twelfth of the sum of its corners, with three times those at the ends of its diagonal: six
/// tetrahedra have these, two each of the others.
struct RowSum {
  double twelfths = 0;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  std::int32_t n_cells = 0;
};

/// Four rows of samples round a row of cells, the first of cell x = first; those of even and odd
/// y and z among them have the ends of diagonals.
template <typename T>
struct SampleRows {
  std::array<const T*, 4> rows;
  const T* even;
  const T* odd;
  std::int32_t first;
};

template <typename T>
void add_row(const T* samples, std::size_t n, RowSum& sum) {
  std::array<double, 4> sums{};
  T low = samples[0];
  T high = samples[0];
  for (std::size_t i = 0; i < n; ++i) {
    sums[i % 4] += static_cast<double>(samples[i]);
    low = std::min(low, samples[i]);
    high = std::max(high, samples[i]);
  }
  const double all = (sums[0] + sums[1]) + (sums[2] + sums[3]);
  // Two cells have all but the ends.
  sum.twelfths += 2 * all - static_cast<double>(samples[0]) - static_cast<double>(samples[n - 1]);
  sum.low = std::min(sum.low, static_cast<double>(low));
  sum.high = std::max(sum.high, static_cast<double>(high));
}

template <typename T>
RowSum sum_row(const SampleRows<T>& rows, CellSpan span) {
  RowSum sum{.n_cells = span.size()};
  const auto from = static_cast<std::size_t>(span.first - rows.first);
  const auto n = static_cast<std::size_t>(span.size());
  for (const T* row : rows.rows) add_row(row + from, n + 1, sum);
  const std::size_t parity = static_cast<std::size_t>(span.first) & 1;
  double ends = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t to_even = (i + parity) & 1;
    ends += static_cast<double>(rows.even[from + i + to_even]) +
            static_cast<double>(rows.odd[from + i + 1 - to_even]);
  }
  sum.twelfths += 2 * ends;
  return sum;
}

/// Without cells that touch a hole.
template <typename T, typename IsHole>
RowSum sum_row_of_holes(const SampleRows<T>& rows, CellSpan span, const IsHole& is_hole) {
  RowSum sum;
  for (std::int32_t x = span.first; x < span.last; ++x) {
    const auto at = static_cast<std::size_t>(x - rows.first);
    const std::size_t to_even = static_cast<std::size_t>(x) & 1;
    double corners = 2 * (static_cast<double>(rows.even[at + to_even]) +
                          static_cast<double>(rows.odd[at + 1 - to_even]));
    double low = sum.low;
    double high = sum.high;
    bool has_hole = false;
    for (const T* row : rows.rows)
      for (const T sample : {row[at], row[at + 1]}) {
        const auto value = static_cast<double>(sample);
        has_hole = has_hole || is_hole(value);
        corners += value;
        low = std::min(low, value);
        high = std::max(high, value);
      }
    if (has_hole) continue;
    sum.twelfths += corners;
    sum.low = low;
    sum.high = high;
    ++sum.n_cells;
  }
  return sum;
}

/// A unit cell's volume, and what rounding may put it off by, as a share.
struct CellVolume {
  double volume = 0;
  double rounding = 0;

  [[nodiscard]] static CellVolume of(const RegularGrid& grid) {
    const Mat3 m = grid.index_to_world_matrix();
    Mat3 sizes;
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t i = 0; i < 3; ++i) sizes.rows[a][i] = std::abs(m.rows[a][i]);
    const auto& [r0, r1, r2] = sizes.rows;
    const double permanent = r0[0] * (r1[1] * r2[2] + r1[2] * r2[1]) +
                             r0[1] * (r1[0] * r2[2] + r1[2] * r2[0]) +
                             r0[2] * (r1[0] * r2[1] + r1[1] * r2[0]);
    const double volume = std::abs(determinant(m));
    return {volume, 0x1p-49 * permanent / volume};
  }
};

/// Adds up the cells of a box of samples.
class BoxSums {
 public:
  BoxSums(const Dataset::Impl& impl, const ProbeCells& facts, const IntegralOptions& options)
      : grid_(impl.info().grid),
        nodata_(impl.info().nodata),
        has_holes_(impl.summary().stats.n_holes > 0),
        has_box_(options.box.has_value()),
        is_whole_number_(!is_floating(impl.info().type) && size_of(impl.info().type) <= 4),
        places_(grid_, options.box),
        volume_(CellVolume::of(grid_)),
        integrator_(facts, options, 0) {}

  /// Those of a row, from samples of `box`.
  template <typename T>
  void add_row_of(const LatticeBox<3>& box, const T* samples, std::int32_t y, std::int32_t z,
                  PartialIntegral& to) const {
    const CellSpan all{box.lower[0], box.upper[0] - 1};
    const CellSpan meeting = has_box_ ? places_.meeting(y, z, all) : all;
    if (meeting.size() == 0) return;
    CellSpan inside = has_box_ ? places_.inside(y, z, meeting) : all;
    if (inside.size() == 0) inside = {meeting.last, meeting.last};
    const SampleRows<T> rows = rows_of(box, samples, y, z);
    for (std::int32_t x = meeting.first; x < inside.first; ++x) add_cut_cell(rows, {{x, y, z}}, to);
    if (inside.size() > 0) add_whole(rows, inside, to);
    for (std::int32_t x = std::max(inside.last, meeting.first); x < meeting.last; ++x)
      add_cut_cell(rows, {{x, y, z}}, to);
  }

 private:
  template <typename T>
  [[nodiscard]] static SampleRows<T> rows_of(const LatticeBox<3>& box, const T* samples,
                                             std::int32_t y, std::int32_t z) {
    const Index<3> edges = box.upper - box.lower;
    SampleRows<T> rows{};
    for (std::size_t k = 0; k < 4; ++k) {
      const Index<3> p{{0, y - box.lower[1] + static_cast<std::int32_t>(k & 1),
                        z - box.lower[2] + static_cast<std::int32_t>(k >> 1)}};
      rows.rows[k] = samples + diamond::linear_index<3>(edges, p);
    }
    const std::size_t even = (static_cast<std::size_t>(y) & 1) | (static_cast<std::size_t>(z) & 1)
                                                                     << 1;
    rows.even = rows.rows[even];
    rows.odd = rows.rows[3 - even];
    rows.first = box.lower[0];
    return rows;
  }
  [[nodiscard]] bool is_hole(double value) const {
    return !std::isfinite(value) || (nodata_ && value == *nodata_);
  }
  template <typename T>
  void add_whole(const SampleRows<T>& rows, CellSpan span, PartialIntegral& to) const {
    const RowSum sum = has_holes_
                           ? sum_row_of_holes(rows, span, [this](double v) { return is_hole(v); })
                           : sum_row(rows, span);
    if (sum.n_cells == 0) return;
    const double volume = volume_.volume * sum.n_cells;
    const double volume_off = volume * (volume_.rounding + 0x1p-52);
    to.volume.add(volume);
    to.volume_rounding += volume_off;
    to.volume_bounds.add(volume - volume_off, volume + volume_off);
    const double integral = volume_.volume * (sum.twelfths / 12);
    // Whole numbers are added up exactly; else each of up to 10 terms a cell rounds the sum.
    const double terms = is_whole_number_ ? 0 : 10.0 * sum.n_cells + 8;
    const double largest = volume * std::max(std::abs(sum.low), std::abs(sum.high));
    const double off = largest * (volume_.rounding + 0x1p-53 * (terms + 4)) * (1 + 0x1p-20);
    to.integral.add(integral);
    to.integral_rounding += off;
    to.integral_bounds.add(integral - off, integral + off);
    add_extremes(sum, to.extremes);
    to.n_cells += kPerCell * static_cast<std::uint64_t>(sum.n_cells);
    to.n_whole += kPerCell * static_cast<std::uint64_t>(sum.n_cells);
  }
  /// F has its extremes over whole cells at samples.
  static void add_extremes(const RowSum& sum, probe_sums::Extremes& to) {
    for (double* const low : {&to.of_cut_low, &to.lowest, &to.reached_low})
      *low = std::min(*low, sum.low);
    for (double* const high : {&to.of_cut_high, &to.highest, &to.reached_high})
      *high = std::max(*high, sum.high);
  }
  /// Of a cell that the box may cut.
  template <typename T>
  void add_cut_cell(const SampleRows<T>& rows, const Index<3>& cell, PartialIntegral& to) const {
    const auto value_at = [&](const Index<3>& p) {
      const std::size_t row = (p[1] > cell[1] ? 1U : 0U) + (p[2] > cell[2] ? 2U : 0U);
      return static_cast<double>(rows.rows[row][p[0] - rows.first]);
    };
    for (std::int32_t k = 0; has_holes_ && k < 8; ++k)
      if (is_hole(value_at(cell + Index<3>{{k & 1, k >> 1 & 1, k >> 2}}))) return;
    for (const auto& simplex : diamond::kuhn_simplices<3>(cell, 1)) {
      IntegralCell made{.is_exact = true};
      for (std::size_t k = 0; k < 4; ++k) {
        const Index<3>& p = simplex.v[k];
        made.corners[k] = grid_.to_world({{double(p[0]), double(p[1]), double(p[2])}});
        made.values[k] = value_at(p);
      }
      const auto& [a, b, c, d] = made.corners;
      if (dot(cross(b - a, c - a), d - a) < 0) {
        std::swap(made.corners[0], made.corners[1]);
        std::swap(made.values[0], made.values[1]);
      }
      integrator_.add(made, to);
    }
  }

  const RegularGrid& grid_;
  std::optional<double> nodata_;
  bool has_holes_;
  bool has_box_;
  bool is_whole_number_;
  CellPlaces places_;
  CellVolume volume_;
  CellIntegrator integrator_;
};

/// Samples of boxes, from memory or from the file.
class BoxReader {
 public:
  [[nodiscard]] static Result<BoxReader> of(const Dataset::Impl& impl,
                                            const IntegralOptions& options, Progress& progress) {
    const std::uint64_t limit =
        options.memory_limit > 0 ? options.memory_limit : physical_memory() / 4;
    const std::uint64_t least =
        diamond::CoarseField<3>::n_bytes(impl.info()) +
        static_cast<std::uint64_t>(kEdge + 1) * (kEdge + 1) * (kEdge + 1) * sizeof(double);
    if (options.memory_limit > 0 && impl.is_in_file() &&
        std::min(least, impl.model_bytes()) > limit)
      return fail("expected a memory limit of at least {} MB to integrate, got {:g} MB",
                  std::min(least, impl.model_bytes()) / 1'000'000 + 1,
                  1e-6 * static_cast<double>(limit));
    BoxReader reader(options.threads);
    LODE_TRY(auto* const chunks, impl.chunks(limit, false));
    if (chunks != nullptr) {
      reader.field_ = &std::get<diamond::CoarseField<3>>(chunks->field);
      reader.blocks_ = &chunks->blocks;
      return reader;
    }
    LODE_TRY(const auto* const model, impl.model(progress));
    reader.model_ = &std::get<Model<3>>(*model);
    return reader;
  }

  template <typename T>
  [[nodiscard]] Result<void> read(const LatticeBox<3>& box, const Progress& progress,
                                  std::vector<T>& out) const {
    const Index<3> edges = box.upper - box.lower;
    out.resize(diamond::n_points<3>(edges));
    if (model_ == nullptr)
      return diamond::FileSamples<3>(*field_, *blocks_, threads_)
          .read(box, progress, std::as_writable_bytes(std::span(out)));
    const auto n_rows = static_cast<std::size_t>(edges[1]);
    parallel_for(static_cast<std::size_t>(edges[2]), threads_, 1, [&](std::size_t z, int) {
      T* to = out.data() + z * n_rows * static_cast<std::size_t>(edges[0]);
      for (std::int32_t y = 0; y < edges[1]; ++y)
        to = diamond::copy_samples<T, 3>(
            *model_, box.lower + Index<3>{{0, y, static_cast<std::int32_t>(z)}}, edges[0], 1, to);
    });
    return {};
  }

 private:
  explicit BoxReader(Threads threads) : threads_(threads) {}

  Threads threads_;
  const Model<3>* model_ = nullptr;
  const diamond::CoarseField<3>* field_ = nullptr;
  store::BlockCache* blocks_ = nullptr;
};

/// Calls body(box) for boxes of samples whose cells are all of these, in an order and of sizes that
/// are always the same. Stops at an error.
template <typename Body>
Result<void> for_each_box(const LatticeBox<3>& cells, const Body& body) {
  Index<3> box_of;
  const auto step = [&](std::size_t i, std::int32_t at) {
    return std::min(cells.upper[i], (at / kEdge + 1) * kEdge);
  };
  for (box_of[2] = cells.lower[2]; box_of[2] < cells.upper[2]; box_of[2] = step(2, box_of[2]))
    for (box_of[1] = cells.lower[1]; box_of[1] < cells.upper[1]; box_of[1] = step(1, box_of[1]))
      for (box_of[0] = cells.lower[0]; box_of[0] < cells.upper[0]; box_of[0] = step(0, box_of[0])) {
        LatticeBox<3> box{box_of, {}};
        for (std::size_t i = 0; i < 3; ++i) box.upper[i] = step(i, box_of[i]) + 1;
        LODE_CHECK(body(box));
      }
  return {};
}

template <typename T>
Result<void> add_boxes(const BoxReader& reader, const BoxSums& sums, const LatticeBox<3>& cells,
                       Threads threads, Progress& progress, PartialIntegral& to) {
  std::vector<T> samples;
  std::vector<PartialIntegral> slabs;
  return for_each_box(cells, [&](const LatticeBox<3>& box) -> Result<void> {
    progress.report("integrating", double{1} * (box.lower[2] - cells.lower[2]) /
                                       (cells.upper[2] - cells.lower[2]));
    LODE_CHECK(reader.read(box, progress, samples));
    if (progress.is_cancelled()) return cancelled_error();
    slabs.assign(static_cast<std::size_t>(box.upper[2] - 1 - box.lower[2]), {});
    parallel_for(slabs.size(), threads, 1, [&](std::size_t slab, int) {
      const std::int32_t z = box.lower[2] + static_cast<std::int32_t>(slab);
      for (std::int32_t y = box.lower[1]; y + 1 < box.upper[1]; ++y)
        sums.add_row_of(box, samples.data(), y, z, slabs[slab]);
    });
    for (const PartialIntegral& slab : slabs) to.add(slab);
    return {};
  });
}

}  // namespace

std::uint64_t n_unit_cells(const Dataset::Impl& impl, const std::optional<Box3d>& box) {
  const LatticeBox<3> cells = cells_round(impl.info().grid, box);
  std::uint64_t n = 1;
  for (int i = 0; i < 3; ++i) n *= static_cast<std::uint64_t>(std::max(0, cells.edge(i)));
  return n;
}

Result<IntegralReport> integrate_samples(const Dataset::Impl& impl, const IntegralOptions& options,
                                         Progress& progress) {
  const RegularGrid& grid = impl.info().grid;
  const diamond::FieldStats& stats = impl.summary().stats;
  ProbeCells facts;
  facts.all = {stats.min, stats.max};
  facts.domain = grid.world_bounds();
  const BoxSums sums(impl, facts, options);
  PartialIntegral sum;
  LODE_TRY(const BoxReader reader, BoxReader::of(impl, options, progress));
  LODE_CHECK(diamond::visit_storage_type(impl.info().type, [&]<typename T>() {
    return add_boxes<T>(reader, sums, cells_round(grid, options.box), options.threads, progress,
                        sum);
  }));
  IntegralReport report = probe_sums::to_report(sum, facts, options.box, 0);
  report.probe.n_cut_cells = report.n_cells;
  return report;
}

}  // namespace lode
