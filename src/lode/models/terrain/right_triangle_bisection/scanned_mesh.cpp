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

/// Where triangles go: from here on, or what is before it, the last one first.
struct TriangleRoom {
  SampleCorners* corners = nullptr;
  float* errors = nullptr;
};

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

/// Walk with numbers: of each corner its index, and its number with it. Or the other way round,
/// from right to left.
template <bool kIsTurned>
class NumberedWalk {
 public:
  NumberedWalk(const ScannedNodes& nodes, const TriangleRoom& room)
      : lattice_(*nodes.lattice),
        errors_(nodes.errors),
        limit_(nodes.limit),
        words_(nodes.words),
        n_before_(nodes.n_before),
        corners_(room.corners),
        mesh_errors_(room.errors) {}

  void under(const LatticeTriangle& t, int depth) {
    const LatticePoint last = lattice_.last();
    const std::int32_t right = std::max({t.a.x, t.b.x, t.c.x});
    const std::int32_t top = std::max({t.a.y, t.b.y, t.c.y});
    if (std::min({t.a.x, t.b.x, t.c.x}) >= last.x || std::min({t.a.y, t.b.y, t.c.y}) >= last.y)
      return;
    const LatticePoint middle = t.middle();
    const bool is_refined = depth > 0 && errors_[lattice_.index(middle)] > limit_;
    if (!is_refined) {
      add(number_of(t.a), number_of(t.b), number_of(t.c),
          depth > 0 ? errors_[lattice_.index(middle)] : 0.0F);
    } else if (right <= last.x && top <= last.y) {
      within(at(t.a), at(t.b), at(t.c), depth);
    } else {
      under(kIsTurned ? t.right() : t.left(), depth - 1);
      under(kIsTurned ? t.left() : t.right(), depth - 1);
    }
  }
  [[nodiscard]] std::size_t n() const { return n_; }

 private:
  struct Corner {
    std::int64_t index;
    std::uint32_t number;
  };

  [[nodiscard]] std::uint32_t number(std::int64_t i) const {
    const auto at = static_cast<std::size_t>(i);
    const std::uint64_t below = words_[at / 64] & ((std::uint64_t{1} << (at % 64)) - 1);
    return n_before_[at / 64] + static_cast<std::uint32_t>(std::popcount(below));
  }
  [[nodiscard]] Corner at(LatticePoint sample) const {
    const auto i = static_cast<std::int64_t>(lattice_.index(sample));
    return {i, number(i)};
  }
  [[nodiscard]] std::uint32_t number_of(LatticePoint node) const {
    return at(lattice_.place(node)).number;
  }
  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c, float error) {
    const auto at =
        kIsTurned ? -1 - static_cast<std::ptrdiff_t>(n_) : static_cast<std::ptrdiff_t>(n_);
    corners_[at] = {a, b, c};
    mesh_errors_[at] = error;
    ++n_;
  }
  /// Of corners that are samples, whose node is refined.
  void within(const Corner& a, const Corner& b, const Corner& c, int depth) {
    const std::int64_t middle = (a.index + b.index) / 2;
    const Corner m{middle, number(middle)};
    half(kIsTurned ? b : c, kIsTurned ? c : a, m, depth - 1);
    half(kIsTurned ? c : b, kIsTurned ? a : c, m, depth - 1);
  }
  void half(const Corner& a, const Corner& b, const Corner& c, int depth) {
    const float error = depth > 0 ? errors_[(a.index + b.index) / 2] : 0;
    if (error > limit_)
      within(a, b, c, depth);
    else
      add(a.number, b.number, c.number, error);
  }

  const Lattice& lattice_;
  const float* errors_;
  float limit_;
  const std::uint64_t* words_;
  const std::uint32_t* n_before_;
  SampleCorners* corners_;
  float* mesh_errors_;
  std::size_t n_ = 0;
};

/// How many triangles there are under a root.
std::size_t walk_numbered(const ScannedNodes& nodes, const LatticeTriangle& root,
                          const TriangleRoom& room) {
  NumberedWalk<false> walk(nodes, room);
  walk.under(root, 2 * (nodes.lattice->n_levels() - 1));
  return walk.n();
}
std::size_t walk_turned(const ScannedNodes& nodes, const LatticeTriangle& root,
                        const TriangleRoom& room) {
  NumberedWalk<true> walk(nodes, room);
  walk.under(root, 2 * (nodes.lattice->n_levels() - 1));
  return walk.n();
}

}  // namespace lode::bisection::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::bisection {
namespace {

HWY_EXPORT(mark_above);
HWY_EXPORT(walk_numbered);
HWY_EXPORT(walk_turned);

/// Nodes beyond the raster that are refined: marks what they stand on, and returns how many. With a
/// reach those whose diamonds come back into the raster have the first multiple of it behind that
/// for a column or a row.
std::size_t mark_beyond(const Bisection& bisection, float limit, SampleMarks& marks) {
  const Lattice& lattice = bisection.lattice();
  const LatticePoint last = lattice.last();
  std::size_t n = 0;
  const auto look_at = [&](LatticePoint node, std::int32_t reach) {
    if (lattice.is_corner(node) || Diamond(node).reach != reach) return;
    if (!lattice.has_node(node, reach) || !(bisection.error(node) > limit)) return;
    marks.add(static_cast<std::int64_t>(lattice.index(lattice.place(node))));
    ++n;
  };
  for (std::int32_t reach = 1; reach <= lattice.side() / 2; reach *= 2) {
    const std::int32_t column = (last.x / reach + 1) * reach;
    const std::int32_t row = (last.y / reach + 1) * reach;
    if (column - reach < last.x && column <= lattice.side())
      for (std::int32_t y = 0; y <= lattice.side(); y += reach) look_at({column, y}, reach);
    if (row - reach < last.y && row <= lattice.side())
      for (std::int32_t x = 0; x <= last.x; x += reach) look_at({x, row}, reach);
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

SampleMesh mesh_by_scan(const Bisection& bisection, float limit, Threads threads) {
  const Lattice& lattice = bisection.lattice();
  SampleMesh mesh{{}, {}, SampleMarks(lattice.stride() * (std::int64_t{lattice.last().y} + 1)), {}};
  mark_samples(bisection, limit, threads, mesh.marks);
  const std::size_t n_beyond = mark_beyond(bisection, limit, mesh.marks);
  count_samples(mesh);
  // Each refined node brings two triangles, or one.
  const std::size_t most = 2 + 2 * (mesh.n_samples + n_beyond);
  mesh.triangles.resize(most);
  mesh.errors.resize(most);
  const ScannedNodes nodes{&lattice, bisection.errors(), limit, mesh.marks.words().data(),
                           mesh.n_before.data()};
  const std::array<LatticeTriangle, 2> halves = roots(lattice);
  SampleCorners* const corners = mesh.triangles.data();
  float* const errors = mesh.errors.data();
  // One from the left, one from the right, where there is room for both.
  constexpr std::size_t kWorthThreads = 1 << 16;  // else waking them takes as long
  std::array<std::size_t, 2> n{};
  parallel_for(2, most < kWorthThreads ? Threads{1} : threads, 1, [&](std::size_t i, int) {
    n[i] = i == 0 ? HWY_DYNAMIC_DISPATCH(walk_numbered)(nodes, halves[0], {corners, errors})
                  : HWY_DYNAMIC_DISPATCH(walk_turned)(nodes, halves[1],
                                                      {corners + most, errors + most});
  });
  if (n[0] + n[1] < most) {
    std::copy_n(corners + (most - n[1]), n[1], corners + n[0]);
    std::copy_n(errors + (most - n[1]), n[1], errors + n[0]);
  }
  mesh.triangles.resize(n[0] + n[1]);
  mesh.errors.resize(n[0] + n[1]);
  return mesh;
}

}  // namespace lode::bisection
#endif
