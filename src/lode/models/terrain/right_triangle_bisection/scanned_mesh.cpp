// Included again by Highway for each instruction set: most count bits in one instruction.
#include "lode/models/terrain/right_triangle_bisection/scanned_mesh.h"

#include <algorithm>
#include <array>
#include <bit>

#include "lode/models/terrain/right_triangle_bisection/walk.h"

#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/terrain/right_triangle_bisection/scanned_mesh.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef LODE_SCANNED_MESH_ONCE
#define LODE_SCANNED_MESH_ONCE
namespace lode::bisection {

/// What a walk looks at.
struct ScannedNodes {
  const Lattice* lattice = nullptr;
  const float* errors = nullptr;
  float limit = 0;
  const std::uint64_t* words = nullptr;
  const std::uint32_t* n_before = nullptr;
};

}  // namespace lode::bisection
#endif

HWY_BEFORE_NAMESPACE();
namespace lode::bisection::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Sets the bits from `first` on of n numbers above the limit.
void mark_above(const float* errors, std::int32_t n, float limit, std::uint64_t* words,
                std::size_t first) {
  const hn::CappedTag<float, 64> d;
  const auto step = static_cast<std::int32_t>(hn::Lanes(d));
  const auto most = hn::Set(d, limit);
  const auto put = [&](std::int32_t x, std::uint64_t bits) {
    const std::size_t at = first + static_cast<std::size_t>(x);
    words[at / 64] |= bits << (at % 64);
    if (at % 64 != 0) words[at / 64 + 1] |= bits >> (64 - at % 64);
  };
  std::int32_t x = 0;
  for (; x + 64 <= n; x += 64) {
    std::uint64_t bits = 0;
    for (std::int32_t k = 0; k < 64; k += step) {
      std::uint64_t some = 0;
      hn::StoreMaskBits(d, hn::Gt(hn::LoadU(d, errors + x + k), most),
                        reinterpret_cast<std::uint8_t*>(&some));
      bits |= some << k;
    }
    put(x, bits);
  }
  for (; x < n; ++x) {
    const std::size_t at = first + static_cast<std::size_t>(x);
    words[at / 64] |= std::uint64_t{errors[x] > limit ? 1U : 0U} << (at % 64);
  }
}

/// Walk with numbers: of each corner its index, and its number with it.
class NumberedWalk {
 public:
  NumberedWalk(const ScannedNodes& nodes, delaunay::Tin& tin)
      : lattice_(*nodes.lattice),
        errors_(nodes.errors),
        limit_(nodes.limit),
        words_(nodes.words),
        n_before_(nodes.n_before),
        tin_(tin) {}

  void under(const LatticeTriangle& t, int depth) {
    const LatticePoint last = lattice_.last();
    const std::int32_t right = std::max({t.a.x, t.b.x, t.c.x});
    const std::int32_t top = std::max({t.a.y, t.b.y, t.c.y});
    if (std::min({t.a.x, t.b.x, t.c.x}) >= last.x || std::min({t.a.y, t.b.y, t.c.y}) >= last.y)
      return;
    const LatticePoint middle = t.middle();
    const bool is_refined = depth > 0 && errors_[lattice_.index(middle)] > limit_;
    if (!is_refined) {
      add(at(t.a), at(t.b), at(t.c), depth > 0 ? errors_[lattice_.index(middle)] : 0.0F);
    } else if (right <= last.x && top <= last.y) {
      within(at(t.a), at(t.b), at(t.c), depth);
    } else {
      under(t.left(), depth - 1);
      under(t.right(), depth - 1);
    }
  }
  /// Puts what is left of the triangles into the mesh.
  void flush() {
    const auto n = static_cast<std::ptrdiff_t>(n_);
    tin_.triangles.insert(tin_.triangles.end(), corners_.begin(), corners_.begin() + n);
    tin_.errors.insert(tin_.errors.end(), errors_there_.begin(), errors_there_.begin() + n);
    n_ = 0;
  }

 private:
  /// A sample's index, and its number above that: so a triangle is passed on in registers.
  using Corner = std::uint64_t;

  static std::uint32_t index_of(Corner corner) { return static_cast<std::uint32_t>(corner); }
  static std::uint32_t number_of(Corner corner) { return static_cast<std::uint32_t>(corner >> 32); }
  /// Where there is a node between them their sum is even; it is far below 2^32.
  static std::uint32_t middle_of(Corner a, Corner b) { return (index_of(a) + index_of(b)) / 2; }

  [[nodiscard]] Corner at(std::uint32_t i) const {
    const std::uint64_t below = words_[i / 64] & ((std::uint64_t{1} << (i % 64)) - 1);
    const std::uint32_t n = n_before_[i / 64] + static_cast<std::uint32_t>(std::popcount(below));
    return std::uint64_t{n} << 32 | i;
  }
  /// Of a node, that of the sample it stands on.
  [[nodiscard]] Corner at(LatticePoint node) const {
    return at(static_cast<std::uint32_t>(lattice_.index(lattice_.place(node))));
  }
  void add(Corner a, Corner b, Corner c, float error) {
    corners_[n_] = {number_of(a), number_of(b), number_of(c)};
    errors_there_[n_] = error;
    if (++n_ == kBuffer) flush();
  }
  /// Of corners that are samples, whose node is refined. Both halves' errors are on their way
  /// before the first decides what comes next, which nobody can guess.
  void within(Corner a, Corner b, Corner c, int depth) {
    const Corner m = at(middle_of(a, b));
    float left = 0;
    float right = 0;
    if (depth > 1) {
      left = errors_[middle_of(c, a)];
      right = errors_[middle_of(b, c)];
    }
    if (left > limit_)
      within(c, a, m, depth - 1);
    else
      add(c, a, m, left);
    if (right > limit_)
      within(b, c, m, depth - 1);
    else
      add(b, c, m, right);
  }

  /// Triangles are put together here first: a vector that has them from the beginning would write
  /// zeros for all of them.
  static constexpr std::size_t kBuffer = 256;

  const Lattice& lattice_;
  const float* errors_;
  float limit_;
  const std::uint64_t* words_;
  const std::uint32_t* n_before_;
  delaunay::Tin& tin_;
  std::array<SampleCorners, kBuffer> corners_;
  std::array<float, kBuffer> errors_there_;
  std::size_t n_ = 0;
};

/// Adds the triangles under a root.
void walk_numbered(const ScannedNodes& nodes, const LatticeTriangle& root, delaunay::Tin& tin) {
  NumberedWalk walk(nodes, tin);
  walk.under(root, 2 * (nodes.lattice->n_levels() - 1));
  walk.flush();
}

}  // namespace lode::bisection::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::bisection {
namespace {

HWY_EXPORT(mark_above);
HWY_EXPORT(walk_numbered);

/// Nodes beyond the raster that are refined: marks what they stand on, and returns how many. With a
/// reach those whose diamonds come back into the raster have the first multiple of it behind that
/// for a column or a row.
std::size_t mark_beyond(const Bisection& bisection, float limit, SampleMarks& marks) {
  const Lattice& lattice = bisection.lattice();
  const LatticePoint last = lattice.last();
  std::size_t n = 0;
  const auto look_at = [&](LatticePoint node, std::int32_t reach) {
    if (!(bisection.error(node) > limit) || !lattice.has_node(node, reach)) return;
    marks.add(static_cast<std::int64_t>(lattice.index(lattice.place(node))));
    ++n;
  };
  for (std::int32_t reach = 1; reach <= lattice.side() / 2; reach *= 2) {
    // A multiple of a reach has it with all other multiples, or if it is even with the odd ones.
    const auto first = [reach](std::int32_t multiple) {
      return (multiple & reach) != 0 ? 0 : reach;
    };
    const auto step = [reach](std::int32_t multiple) {
      return (multiple & reach) != 0 ? reach : 2 * reach;
    };
    const std::int32_t column = (last.x / reach + 1) * reach;
    const std::int32_t row = (last.y / reach + 1) * reach;
    if (column - reach < last.x && column <= lattice.side())
      for (std::int32_t y = first(column); y <= lattice.side(); y += step(column))
        look_at({column, y}, reach);
    if (row - reach < last.y && row <= lattice.side())
      for (std::int32_t x = first(row); x <= last.x; x += step(row)) look_at({x, row}, reach);
  }
  return n;
}

/// Whole rows of words at once, so that no two threads write to one.
void mark_samples(const Bisection& bisection, float limit, Threads threads, SampleMarks& marks) {
  constexpr std::int32_t kRows = 64;
  const Lattice& lattice = bisection.lattice();
  const std::int32_t n_rows = lattice.last().y + 1;
  constexpr std::size_t kWorthThreads = 1 << 19;
  const auto n_parts = static_cast<std::size_t>((n_rows + kRows - 1) / kRows);
  parallel_for(n_parts, lattice.size() < kWorthThreads ? Threads{1} : threads, 1,
               [&](std::size_t part, int) {
                 const auto first = static_cast<std::int32_t>(part) * kRows;
                 for (std::int32_t y = first; y < std::min(n_rows, first + kRows); ++y) {
                   const std::size_t row = lattice.index({0, y});
                   HWY_DYNAMIC_DISPATCH(mark_above)
                   (bisection.errors() + row, lattice.last().x + 1, limit, marks.data(), row);
                 }
               });
  for (const LatticePoint corner :
       {LatticePoint{0, 0}, {lattice.last().x, 0}, {0, lattice.last().y}, lattice.last()})
    marks.add(static_cast<std::int64_t>(lattice.index(corner)));
}

}  // namespace

MeshScan::MeshScan(const Bisection& bisection, float limit, Threads threads)
    : bisection_(bisection),
      limit_(limit),
      mesh_{{},
            {},
            SampleMarks(bisection.lattice().stride() *
                        (std::int64_t{bisection.lattice().last().y} + 1)),
            {}} {
  mark_samples(bisection, limit, threads, mesh_.marks);
  const std::size_t n_beyond = mark_beyond(bisection, limit, mesh_.marks);
  count_samples(mesh_);
  most_triangles_ = 2 + 2 * (mesh_.n_samples + n_beyond);
}

void MeshScan::walk(std::size_t half, delaunay::Tin& tin) const {
  const Lattice& lattice = bisection_.lattice();
  const ScannedNodes nodes{&lattice, bisection_.errors(), limit_, mesh_.marks.words().data(),
                           mesh_.n_before.data()};
  HWY_DYNAMIC_DISPATCH(walk_numbered)(nodes, roots(lattice)[half], tin);
}

}  // namespace lode::bisection
#endif
