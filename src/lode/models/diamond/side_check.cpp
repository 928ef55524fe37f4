#include "lode/models/diamond/side_check.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "lode/models/diamond/lattice.h"

namespace lode::diamond {
namespace {

using Point2 = std::array<double, 2>;

/// How far beside the rows rays run, in steps of the grid; what fails all of them is wrong.
constexpr std::array<Point2, 3> kBeside = {
    {{0.00031415, 0.00027183}, {0.0000057721, 0.0000091596}, {0.0000041421, 0.0000016180}}};

/// Rows of samples along an axis, with the rays beside them, and where a surface crosses these.
class RowCrossings {
 public:
  RowCrossings(const Index3& dims, std::size_t axis, const Point2& beside)
      : dims_(dims),
        axis_(axis),
        across_{(axis + 1) % 3, (axis + 2) % 3},
        beside_(beside),
        stride_(as_size(dims[axis])),
        net_(stride_ * n_rows(), 0) {}

  [[nodiscard]] std::size_t n_rows() const {
    return as_size(dims_[across_[0]]) * as_size(dims_[across_[1]]);
  }
  /// The sample at x of a row.
  [[nodiscard]] Index3 sample(std::size_t row, std::int32_t x) const {
    Index3 p;
    p[axis_] = x;
    p[across_[0]] = static_cast<std::int32_t>(row % as_size(dims_[across_[0]]));
    p[across_[1]] = static_cast<std::int32_t>(row / as_size(dims_[across_[0]]));
    return p;
  }
  /// The cell that the ray beside the row runs through from x on.
  [[nodiscard]] Index3 cell(std::size_t row, std::int32_t x) const {
    Index3 p = sample(row, x);
    for (const std::size_t i : across_)
      if (is_turned(i, p[i])) --p[i];
    return p;
  }
  /// How much more often than the other way it is crossed between samples x - 1 and x from higher
  /// to lower values; modulo 256.
  [[nodiscard]] std::uint8_t net_fall(std::size_t row, std::int32_t x) const {
    return net_[row * stride_ + as_size(x)];
  }

  /// From many threads. Corners in index coordinates, counter-clockwise seen from lower values.
  void add(const std::array<Vec3d, 3>& t) {
    std::array<std::array<std::int32_t, 2>, 2> range{};
    for (std::size_t i = 0; i < 2; ++i) {
      const auto [low, high] = std::minmax({t[0][across_[i]], t[1][across_[i]], t[2][across_[i]]});
      const double last = static_cast<double>(dims_[across_[i]] - 1);
      range[i] = {static_cast<std::int32_t>(std::clamp(std::floor(low), 0.0, last)),
                  static_cast<std::int32_t>(std::clamp(std::ceil(high), 0.0, last))};
    }
    for (std::int32_t v = range[1][0]; v <= range[1][1]; ++v)
      for (std::int32_t u = range[0][0]; u <= range[0][1]; ++u) {
        const auto crossed = crossing(t, {ray(0, u), ray(1, v)});
        if (!crossed) continue;
        const auto next = static_cast<std::int32_t>(
            std::clamp(std::ceil(crossed->at), 0.0, static_cast<double>(dims_[axis_])));
        const std::size_t row = as_size(v) * as_size(dims_[across_[0]]) + as_size(u);
        if (next < dims_[axis_])
          std::atomic_ref(net_[row * stride_ + as_size(next)])
              .fetch_add(crossed->falls ? std::uint8_t{1} : std::uint8_t{255},
                         std::memory_order_relaxed);
      }
  }

 private:
  [[nodiscard]] bool is_turned(std::size_t axis, std::int32_t at) const {
    return at == dims_[axis] - 1;
  }
  /// Inside the domain: at its upper border on the other side.
  [[nodiscard]] double ray(std::size_t i, std::int32_t at) const {
    return static_cast<double>(at) + (is_turned(across_[i], at) ? -beside_[i] : beside_[i]);
  }
  [[nodiscard]] Point2 flat(const Vec3d& p) const { return {p[across_[0]], p[across_[1]]}; }

  /// Which side of an edge a point is on; the other triangle at the edge finds the same.
  [[nodiscard]] static bool is_left(Point2 a, Point2 b, const Point2& p) {
    const bool swaps = b < a;
    if (swaps) std::swap(a, b);
    const bool is_left = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0;
    return is_left != swaps;
  }
  struct Crossing {
    double at = 0;
    bool falls = false;  ///< From higher to lower values, along the axis.
  };
  [[nodiscard]] std::optional<Crossing> crossing(const std::array<Vec3d, 3>& t,
                                                 const Point2& p) const {
    const std::array<Point2, 3> q = {flat(t[0]), flat(t[1]), flat(t[2])};
    const bool left = is_left(q[0], q[1], p);
    if (left != is_left(q[1], q[2], p) || left != is_left(q[2], q[0], p)) return {};
    const double whole =
        (q[1][0] - q[0][0]) * (q[2][1] - q[0][1]) - (q[1][1] - q[0][1]) * (q[2][0] - q[0][0]);
    const auto part = [&](std::size_t i, std::size_t j) {
      return (q[i][0] - p[0]) * (q[j][1] - p[1]) - (q[i][1] - p[1]) * (q[j][0] - p[0]);
    };
    const double x =
        (part(1, 2) * t[0][axis_] + part(2, 0) * t[1][axis_] + part(0, 1) * t[2][axis_]) / whole;
    const auto [low, high] = std::minmax({t[0][axis_], t[1][axis_], t[2][axis_]});
    return Crossing{std::isfinite(x) ? std::clamp(x, low, high) : low, left};
  }

  Index3 dims_;
  std::size_t axis_;
  std::array<std::size_t, 2> across_;
  Point2 beside_;
  std::size_t stride_;
  std::vector<std::uint8_t> net_;
};

using Pair = std::array<Index3, 2>;

bool is_in_box(const Box3d& box, const Vec3d& p) {
  return p[0] >= box.lower[0] && p[1] >= box.lower[1] && p[2] >= box.lower[2] &&
         p[0] <= box.upper[0] && p[1] <= box.upper[1] && p[2] <= box.upper[2];
}

/// Which samples are asked about, and on which side they are.
class KnownSides {
 public:
  enum Side : std::int8_t { below = -1, unknown = 0, above = 1 };

  KnownSides(const FieldSamples& samples, const SideOptions& options)
      : samples_(samples), options_(options), dims_(samples.grid().dims) {
    if (options.reach == Index3{}) return;
    sides_.resize(static_cast<std::size_t>(samples.grid().n_samples()));
    const std::size_t n_rows = as_size(dims_[1]) * as_size(dims_[2]);
    parallel_for(n_rows, options.threads, 16, [&](std::size_t row, int) {
      for (std::int32_t x = 0; x < dims_[0]; ++x) {
        const Index3 p{{x, static_cast<std::int32_t>(row % as_size(dims_[1])),
                        static_cast<std::int32_t>(row / as_size(dims_[1]))}};
        sides_[index_of(p)] = side_of(p);
      }
    });
    const std::vector<Side> own = sides_;
    for (std::size_t axis = 0; axis < 3; ++axis) shrink(axis);
    if (!options.is_far) return;
    parallel_for(n_rows, options.threads, 16, [&](std::size_t row, int) {
      for (std::size_t at = row * as_size(dims_[0]); at < (row + 1) * as_size(dims_[0]); ++at)
        if (sides_[at] == unknown && own[at] != unknown && options.is_far(place_of(at)))
          sides_[at] = own[at];
    });
  }

  [[nodiscard]] Side at(const Index3& p) const {
    return sides_.empty() ? side_of(p) : sides_[index_of(p)];
  }

 private:
  [[nodiscard]] std::size_t index_of(const Index3& p) const { return linear_index<3>(dims_, p); }
  [[nodiscard]] Vec3d place_of(std::size_t at) const {
    const Index3 p = point_of<3>(dims_, at);
    return samples_.grid().to_world({{1.0 * p[0], 1.0 * p[1], 1.0 * p[2]}});
  }
  [[nodiscard]] Side side_of(const Index3& p) const {
    const double more = samples_.sample(p) - options_.isovalue;
    if (!(std::abs(more) > options_.error)) return unknown;
    return more > 0 ? above : below;
  }
  /// Along an axis, leaves what is alike up to the reach, or to the end of the data.
  void shrink(std::size_t axis) {
    const std::int32_t reach = options_.reach[axis];
    const std::array<std::size_t, 2> across{(axis + 1) % 3, (axis + 2) % 3};
    const std::size_t n_rows = as_size(dims_[across[0]]) * as_size(dims_[across[1]]);
    const std::int32_t n = dims_[axis];
    parallel_for(n_rows, options_.threads, 16, [&](std::size_t row, int) {
      Index3 p;
      p[across[0]] = static_cast<std::int32_t>(row % as_size(dims_[across[0]]));
      p[across[1]] = static_cast<std::int32_t>(row / as_size(dims_[across[0]]));
      const auto side = [&](std::int32_t x) -> Side& {
        p[axis] = x;
        return sides_[index_of(p)];
      };
      for (std::int32_t first = 0; first < n;) {
        const Side here = side(first);
        std::int32_t last = first + 1;
        while (last < n && side(last) == here) ++last;
        const std::int32_t low = first == 0 ? 0 : first + reach;
        const std::int32_t high = last == n ? n : last - reach;
        for (std::int32_t x = first; x < last; ++x)
          if (x < low || x >= high) side(x) = unknown;
        first = last;
      }
    });
  }

  const FieldSamples& samples_;
  const SideOptions& options_;
  Index3 dims_;
  std::vector<Side> sides_;  ///< None where nothing is in reach.
};

class SideChecker {
 public:
  /// `seen_from`: lower or higher values.
  SideChecker(const FieldSamples& samples, const Surface& surface, const SideOptions& options,
              const KnownSides& known, SeenFrom seen_from)
      : samples_(samples),
        surface_(surface),
        options_(options),
        known_(known),
        is_turned_((determinant(samples.grid().index_to_world_matrix()) < 0) !=
                   (seen_from == SeenFrom::higher_values)) {}

  Result<SideReport> run(Progress& progress) {
    SideReport report;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::vector<Pair> wrong;
      for (std::size_t i = 0; i < kBeside.size() && (i == 0 || !wrong.empty()); ++i) {
        progress.report("sides", (static_cast<double>(axis) + 0.3 * static_cast<double>(i)) / 3);
        std::uint64_t n_pairs = 0;
        const std::vector<Pair> found = find_wrong(axis, kBeside[i], n_pairs, progress);
        if (progress.is_cancelled()) return cancelled_error();
        if (i == 0) {
          report.n_pairs += n_pairs;
          wrong = found;
        } else {
          std::vector<Pair> both;
          std::ranges::set_intersection(wrong, found, std::back_inserter(both));
          wrong = std::move(both);
        }
      }
      if (report.n_wrong == 0 && !wrong.empty()) report.first = wrong.front();
      report.n_wrong += wrong.size();
    }
    return report;
  }

 private:
  [[nodiscard]] std::vector<Pair> find_wrong(std::size_t axis, const Point2& beside,
                                             std::uint64_t& n_pairs,
                                             const Progress& progress) const {
    RowCrossings rows(samples_.grid().dims, axis, beside);
    const RegularGrid& grid = samples_.grid();
    parallel_for(surface_.triangles.size(), options_.threads, 4096, [&](std::size_t i, int) {
      std::array<Vec3d, 3> corners;
      for (std::size_t k = 0; k < 3; ++k)
        corners[k] = grid.to_index(surface_.world_position(surface_.triangles[i][k]));
      if (is_turned_) std::swap(corners[1], corners[2]);
      rows.add(corners);
    });
    std::vector<Pair> wrong;
    std::mutex mutex;
    parallel_for(rows.n_rows(), options_.threads, 64, [&](std::size_t row, int) {
      if (progress.is_cancelled()) return;
      std::vector<Pair> found;
      const std::uint64_t n = check_row(rows, row, grid.dims[axis], found);
      const std::lock_guard lock(mutex);
      n_pairs += n;
      wrong.insert(wrong.end(), found.begin(), found.end());
    });
    std::ranges::sort(wrong);
    return wrong;
  }

  [[nodiscard]] std::uint64_t check_row(const RowCrossings& rows, std::size_t row, std::int32_t n,
                                        std::vector<Pair>& wrong) const {
    std::uint64_t n_pairs = 0;
    KnownSides::Side side_before = KnownSides::unknown;
    Index3 last;
    std::uint8_t net_fall = 0;  // since then
    for (std::int32_t x = 0; x < n; ++x) {
      if (x > 0 && options_.has_holes && is_removed_cell(samples_, rows.cell(row, x - 1)))
        side_before = KnownSides::unknown;
      net_fall = static_cast<std::uint8_t>(net_fall + rows.net_fall(row, x));
      const Index3 at = rows.sample(row, x);
      const KnownSides::Side side = known_.at(at);
      if (side == KnownSides::unknown) continue;
      if (side_before != KnownSides::unknown && is_asked(last, at)) {
        ++n_pairs;
        if (net_fall != static_cast<std::uint8_t>((side_before - side) / 2))
          wrong.push_back({last, at});
      }
      last = at;
      side_before = side;
      net_fall = 0;
    }
    return n_pairs;
  }

  [[nodiscard]] bool is_asked(const Index3& a, const Index3& b) const {
    const auto world = [&](const Index3& p) {
      return samples_.grid().to_world({{1.0 * p[0], 1.0 * p[1], 1.0 * p[2]}});
    };
    const auto has_both = [&](const Box3d& box) {
      return is_in_box(box, world(a)) && is_in_box(box, world(b));
    };
    return options_.boxes.empty() || std::ranges::any_of(options_.boxes, has_both);
  }

  const FieldSamples& samples_;
  const Surface& surface_;
  const SideOptions& options_;
  const KnownSides& known_;
  bool is_turned_;  ///< Triangles, in index coordinates.
};

}  // namespace

Result<SideReport> check_sides(const FieldSamples& samples, const Surface& surface,
                               const SideOptions& options, Progress& progress) {
  const KnownSides known(samples, options);
  const auto look = [&](SeenFrom seen_from) -> Result<SideReport> {
    LODE_TRY(SideReport report,
             SideChecker(samples, surface, options, known, seen_from).run(progress));
    report.seen_from = seen_from;
    return report;
  };
  if (options.seen_from != SeenFrom::either) return look(options.seen_from);
  LODE_TRY(const SideReport report, look(SeenFrom::lower_values));
  if (report.n_wrong == 0) return report;
  LODE_TRY(const SideReport turned, look(SeenFrom::higher_values));
  return turned.n_wrong < report.n_wrong ? turned : report;
}

}  // namespace lode::diamond
