#include "lode/models/diamond/crossing_nets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/diamond/crossing_nets.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lode::diamond::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Bytes = hn::CappedTag<std::int8_t, 32>;
using ByteVec = hn::Vec<Bytes>;

/// All bits set at even places, and at the first 32.
struct LanePatterns {
  alignas(64) std::int8_t even[64];
  alignas(64) std::int8_t first[64];
};
constexpr LanePatterns kPatterns = [] {
  LanePatterns patterns{};
  for (int i = 0; i < 64; ++i) {
    patterns.even[i] = (i & 1) == 0 ? -1 : 0;
    patterns.first[i] = i < 32 ? -1 : 0;
  }
  return patterns;
}();

/// -1 where u > v.
HWY_INLINE ByteVec is_above(ByteVec u, ByteVec v) { return hn::VecFromMask(Bytes(), hn::Gt(u, v)); }
/// 1 where u < v, -1 where u > v.
HWY_INLINE ByteVec sign_of(ByteVec u, ByteVec v) { return hn::Sub(is_above(u, v), is_above(v, u)); }

HWY_INLINE ByteVec majority(ByteVec x, ByteVec y, ByteVec z) {
  return hn::Or(hn::And(x, y), hn::And(z, hn::Or(x, y)));
}

/// One row's samples, those at lanes' places, one further, and at even and odd coordinates.
struct RowRanks {
  ByteVec left, right, even, odd;
};
struct RowNets {
  ByteVec left, even, odd;
};

/// The triangles of 6 tetrahedra, at the corners of their cell: by number, whose bits say where a
/// coordinate is odd. All of them go from corner 0 to 7 over one with one bit and one with two.
HWY_INLINE void find_triangles(const ByteVec (&corner)[8], ByteVec (&net)[8]) {
  const Bytes d;
  ByteVec upper[8];
  for (ByteVec& sum : upper) sum = hn::Zero(d);
  const ByteVec ends = is_above(corner[0], corner[7]);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t p = std::size_t{1} << i;
    const ByteVec first_p = is_above(corner[0], corner[p]);
    const ByteVec p_last = is_above(corner[p], corner[7]);
    for (std::size_t j = 0; j < 3; ++j) {
      if (j == i) continue;
      const std::size_t q = 7 ^ (std::size_t{1} << j);
      const ByteVec first_q = is_above(corner[0], corner[q]);
      const ByteVec p_q = is_above(corner[p], corner[q]);
      const ByteVec q_last = is_above(corner[q], corner[7]);
      // Whether each is one of the two highest; of the four, two are.
      const ByteVec high_first = majority(first_p, first_q, ends);
      const ByteVec high_p = majority(hn::Not(first_p), p_q, p_last);
      const ByteVec high_q = majority(hn::Not(first_q), hn::Not(p_q), q_last);
      upper[0] = hn::Add(upper[0], high_first);
      upper[p] = hn::Add(upper[p], high_p);
      upper[q] = hn::Add(upper[q], high_q);
      upper[7] = hn::Add(upper[7], hn::Xor(high_first, hn::Xor(high_p, high_q)));
    }
  }
  for (std::size_t i = 0; i < 8; ++i) {
    const auto n_simplices = static_cast<std::int8_t>(i == 0 || i == 7 ? 6 : 2);
    net[i] = hn::Add(hn::Set(d, n_simplices), hn::Add(upper[i], upper[i]));
  }
}

HWY_INLINE void add_edge(ByteVec low, ByteVec high, ByteVec& at_low, ByteVec& at_high) {
  const ByteVec sign = sign_of(low, high);
  at_low = hn::Add(at_low, sign);
  at_high = hn::Sub(at_high, sign);
}

/// The edges that begin at the lowest corners, which lie in row `own` of four, [y + 2 z] by parity.
HWY_INLINE void find_edges(const RowRanks (&row)[4], std::size_t own, RowNets (&net)[4]) {
  const std::size_t y = own & 1;
  const std::size_t z = own & 2;
  add_edge(row[own].even, row[own].odd, net[own].even, net[own].odd);
  add_edge(row[own].left, row[own ^ 1].left, net[own].left, net[own ^ 1].left);
  add_edge(row[own].left, row[own ^ 2].left, net[own].left, net[own ^ 2].left);
  add_edge(row[0].left, row[3].left, net[0].left, net[3].left);
  add_edge(row[z].even, row[z + 1].odd, net[z].even, net[z + 1].odd);
  add_edge(row[y].even, row[y + 2].odd, net[y].even, net[y + 2].odd);
  add_edge(row[0].even, row[3].odd, net[0].even, net[3].odd);
}

HWY_INLINE void add_to(std::int8_t* at, ByteVec net) {
  const Bytes d;
  hn::StoreU(hn::Add(hn::LoadU(d, at), net), d, at);
}

struct LayerRow {
  NetSlice* slice[4];  ///< Of each row of corners, [y + 2 z] by parity,
  std::size_t at[4];   ///< and where it begins there.
  std::size_t own;     ///< Which one has the lowest corners.
};

HWY_INLINE void add_cells(const LayerRow& cells, std::size_t x, std::int32_t n_cells) {
  const Bytes d;
  const auto even = hn::MaskFromVec(hn::LoadU(d, kPatterns.even + x));
  RowRanks row[4];
  for (std::size_t r = 0; r < 4; ++r) {
    const std::int8_t* rank = cells.slice[r]->rank.data() + cells.at[r] + x;
    row[r].left = hn::LoadU(d, rank);
    row[r].right = hn::LoadU(d, rank + 1);
  }
  ByteVec differs = hn::Xor(row[0].left, row[0].right);
  for (std::size_t r = 1; r < 4; ++r)
    differs = hn::Or(differs,
                     hn::Or(hn::Xor(row[0].left, row[r].left), hn::Xor(row[0].left, row[r].right)));
  const auto first = 32 - static_cast<std::size_t>(n_cells);
  const ByteVec kept = hn::And(hn::VecFromMask(d, hn::Ne(differs, hn::Zero(d))),
                               hn::LoadU(d, kPatterns.first + first + x));
  if (hn::AllTrue(d, hn::Eq(kept, hn::Zero(d)))) return;
  ByteVec corner[8];
  RowNets edges[4];
  for (std::size_t r = 0; r < 4; ++r) {
    row[r].even = corner[2 * r] = hn::IfThenElse(even, row[r].left, row[r].right);
    row[r].odd = corner[2 * r + 1] = hn::IfThenElse(even, row[r].right, row[r].left);
    edges[r].left = edges[r].even = edges[r].odd = hn::Zero(d);
  }
  ByteVec net[8];
  find_triangles(corner, net);
  find_edges(row, cells.own, edges);
  for (std::size_t r = 0; r < 4; ++r) {
    NetSlice& slice = *cells.slice[r];
    const std::size_t at = cells.at[r] + x;
    const ByteVec a = hn::And(net[2 * r], kept);
    const ByteVec b = hn::And(net[2 * r + 1], kept);
    add_to(slice.left_triangles.data() + at, hn::IfThenElse(even, a, b));
    add_to(slice.right_triangles.data() + at + 1, hn::IfThenElse(even, b, a));
    const ByteVec e = hn::And(edges[r].even, kept);
    const ByteVec o = hn::And(edges[r].odd, kept);
    add_to(slice.left_edges.data() + at,
           hn::Add(hn::IfThenElse(even, e, o), hn::And(edges[r].left, kept)));
    add_to(slice.right_edges.data() + at + 1, hn::IfThenElse(even, o, e));
  }
}

void add_layer(const CellLayer& layer) {
  const std::size_t z = layer.is_odd ? 1 : 0;
  for (std::int32_t y = 0; y < layer.n_rows; ++y) {
    LayerRow cells{};
    cells.own = static_cast<std::size_t>(y & 1) + 2 * z;
    for (std::size_t r = 0; r < 4; ++r) {
      const auto odd_y = static_cast<std::int32_t>(r & 1);
      const std::int32_t row = odd_y != 0 ? y | 1 : y + (y & 1);
      cells.slice[r] = r / 2 == z ? &layer.lower : &layer.upper;
      cells.at[r] = static_cast<std::size_t>(row) * NetSlice::kStride;
    }
    for (std::size_t x = 0; x < 32; x += hn::Lanes(Bytes())) add_cells(cells, x, layer.n_cells);
  }
}

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {

HWY_EXPORT(add_layer);

void add_crossing_nets(const CellLayer& layer) { HWY_DYNAMIC_DISPATCH(add_layer)(layer); }

void NetSlice::clear() {
  for (Row* row : {&left_triangles, &right_triangles, &left_edges, &right_edges}) row->fill(0);
}

}  // namespace lode::diamond
#endif
