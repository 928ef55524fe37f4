#include "lode/models/terrain/right_triangle_bisection/stretched_diamonds.h"

#include <algorithm>
#include <array>
#include <type_traits>
#include <vector>

#include "lode/delaunay/triangle_error.h"
#include "lode/delaunay/triangle_rows.h"
#include "lode/delaunay/worst_sample.h"

namespace lode::bisection {
namespace {

std::vector<LatticePoint> stretched_nodes(const Lattice& lattice) {
  std::vector<LatticePoint> nodes;
  const auto add = [&](std::int32_t x, std::int32_t y, std::int32_t reach) {
    const bool is_of_reach = ((x | y) & reach) != 0;
    if (is_of_reach && lattice.has({x, y})) nodes.push_back({x, y});
  };
  const LatticePoint last = lattice.last();
  // Those that take longest first, for who divides them among threads.
  for (std::int32_t reach = lattice.side() / 2; reach >= 1; reach /= 2) {
    // At most two columns and rows of nodes reach over the last ones of the raster.
    const auto across = [&](std::int32_t i, std::int32_t end) {
      return i - reach < end && std::min(i + reach, lattice.side()) > end;
    };
    const std::int32_t first_x = last.x / reach * reach;
    const std::int32_t first_y = last.y / reach * reach;
    for (std::int32_t x = first_x; x <= first_x + reach; x += reach)
      for (std::int32_t y = 0; across(x, last.x) && y - reach < last.y; y += reach)
        add(x, y, reach);
    for (std::int32_t y = first_y; y <= first_y + reach; y += reach)
      for (std::int32_t x = 0; across(y, last.y) && x - reach < last.x; x += reach)
        if (!across(x, last.x)) add(x, y, reach);
  }
  return nodes;
}

template <typename T>
class TriangleMeter {
 public:
  TriangleMeter(const RasterRows<T>& rows, const HeightRange& range, bool is_exact,
                const Lattice& lattice)
      : is_exact_(is_exact),
        rows_{rows.samples, rows.stride, delaunay::LatticePacking(lattice.last().x + 1)},
        slack_(delaunay::lane_slack<T>(range.lower, range.upper)),
        exact_slack_(delaunay::double_slack(range.lower, range.upper)),
        find_(delaunay::find_worst_sample<T>()) {}

  /// Of corners that turn left.
  [[nodiscard]] double error(const std::array<LatticePoint, 3>& corners) const {
    std::array<std::uint32_t, 3> packed{};
    std::array<double, 3> z{};
    for (std::size_t i = 0; i < 3; ++i) {
      packed[i] = rows_.packing.pack(corners[i]);
      z[i] = rows_.height(corners[i]);
    }
    const auto worst = find_(rows_, slack_, packed, z);
    // Residuals of whole numbers, times the area, are such.
    if constexpr (std::is_integral_v<T>)
      if (worst.error *
              static_cast<double>(delaunay::doubled_area(corners[0], corners[1], corners[2])) <
          1)
        return 0;
    // Where rounding is much of it: planes have no error at all.
    if (worst.error > 4 * worst.slack) return worst.error;
    if constexpr (std::is_floating_point_v<T>)
      if (is_exact_) return multiples_error(corners);
    return delaunay::find_worst_exactly(rows_, exact_slack_, packed).error;
  }

 private:
  /// Of heights that are multiples of 2^-8, in integers.
  [[nodiscard]] double multiples_error(const std::array<LatticePoint, 3>& corners) const {
    __extension__ using Wide = __int128;
    constexpr double kMultiples = 256;
    const auto& [a, b, c] = corners;
    const auto z = [&](LatticePoint p) {
      return static_cast<std::int64_t>(rows_.height(p) * kMultiples);
    };
    const std::int64_t area = delaunay::doubled_area(a, b, c);
    Wide worst = 0;
    for (delaunay::TriangleRows row(a, b, c); row.has_row(); row.next())
      for (std::int32_t x = row.first(); x <= row.last(); ++x) {
        const LatticePoint p{x, row.y()};
        const Wide residual = Wide{area} * z(p) - Wide{delaunay::doubled_area(b, c, p)} * z(a) -
                              Wide{delaunay::doubled_area(c, a, p)} * z(b) -
                              Wide{delaunay::doubled_area(a, b, p)} * z(c);
        worst = std::max(worst, residual < 0 ? -residual : residual);
      }
    // Three roundings.
    return static_cast<double>(worst) / (static_cast<double>(area) * kMultiples) * (1 + 0x1p-50);
  }

  bool is_exact_;
  delaunay::SampleRows<T> rows_;
  delaunay::RoundingSlack slack_;
  delaunay::RoundingSlack exact_slack_;
  delaunay::FindWorst<T> find_;
};

}  // namespace

template <typename T>
void set_stretched_errors(const RasterRows<T>& rows, const HeightRange& range, bool is_exact,
                          const Lattice& lattice, Threads threads, float* errors) {
  const std::vector<LatticePoint> nodes = stretched_nodes(lattice);
  if (nodes.empty()) return;
  const TriangleMeter<T> meter(rows, range, is_exact, lattice);
  parallel_for(nodes.size(), threads, 16, [&](std::size_t i, int) {
    const Diamond diamond(nodes[i]);
    const LatticePoint a = lattice.place(diamond.ends[0]);
    const LatticePoint b = lattice.place(diamond.ends[1]);
    double error = 0;
    for (const bool is_left : {true, false}) {
      const LatticePoint apex = diamond.apexes[is_left ? 0 : 1];
      if (!lattice.has(apex)) continue;
      const LatticePoint c = lattice.place(apex);
      const std::array corners = is_left ? std::array{a, b, c} : std::array{b, a, c};
      if (delaunay::doubled_area(corners[0], corners[1], corners[2]) > 0)
        error = std::max(error, meter.error(corners));
    }
    errors[lattice.index(nodes[i])] = delaunay::to_float_above(error);
  });
}

template void set_stretched_errors(const RasterRows<std::int16_t>&, const HeightRange&, bool,
                                   const Lattice&, Threads, float*);
template void set_stretched_errors(const RasterRows<std::uint16_t>&, const HeightRange&, bool,
                                   const Lattice&, Threads, float*);
template void set_stretched_errors(const RasterRows<float>&, const HeightRange&, bool,
                                   const Lattice&, Threads, float*);
template void set_stretched_errors(const RasterRows<double>&, const HeightRange&, bool,
                                   const Lattice&, Threads, float*);

}  // namespace lode::bisection
