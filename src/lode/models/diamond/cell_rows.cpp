#include "lode/models/diamond/cell_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/diamond/cell_rows.cpp"
#define HWY_WANT_AVX3_DL
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace lode::diamond::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Words = hn::CappedTag<std::uint32_t, SignField::kPadding>;
using WordsV = hn::Vec<Words>;

HWY_INLINE WordsV word_mask(bool all) {
  return hn::Set(Words(), all ? ~std::uint32_t{0} : std::uint32_t{0});
}

/// The corners of the cells in several words: of each row the signs at the cells' own x, and at the
/// next one.
struct CornerWords {
  CornerWords(const CellRow& cells, std::size_t word) {
    const Words d;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t* from = cells.rows()[i] + word;
      row[i] = hn::LoadU(d, from);
      next[i] = hn::Or(hn::ShiftRight<1>(row[i]), hn::ShiftLeft<31>(hn::LoadU(d, from + 1)));
    }
    samples = hn::LoadU(d, cells.field().sample_bits.data() + word);
    in_cells = hn::LoadU(d, cells.field().cell_bits.data() + word);
  }

  /// Whether no edge is crossed: the corners at the next x may be another vector's.
  [[nodiscard]] HWY_INLINE bool is_uniform() const {
    const auto across =
        hn::Or(hn::Or(hn::Xor(row[0], row[1]), hn::Xor(row[0], row[2])), hn::Xor(row[0], row[3]));
    const auto along = hn::Or(hn::Or(hn::Xor(row[0], next[0]), hn::Xor(row[0], next[1])),
                              hn::Or(hn::Xor(row[0], next[2]), hn::Xor(row[0], next[3])));
    const Words d;
    return hn::AllTrue(
        d, hn::Eq(hn::Or(hn::And(across, samples), hn::And(along, in_cells)), hn::Zero(d)));
  }

  WordsV row[4];
  WordsV next[4];
  WordsV samples, in_cells;  ///< Which bits are samples, and at which cells begin.
};

/// Calls put(series, crossed anchors) for the first kOwnSeries of them, or all.
template <bool kAll, typename Put>
HWY_INLINE void for_each_series(const CellRow& cells, const CornerWords& c, const Put& put) {
  const Words d;
  const auto even = hn::Set(d, 0x55555555U);
  const auto along_x = [&](std::size_t i)
                           HWY_ATTR { return hn::And(hn::Xor(c.row[i], c.next[i]), c.in_cells); };
  const auto across = [&](std::size_t i, std::size_t j)
                          HWY_ATTR { return hn::And(hn::Xor(c.row[i], c.row[j]), c.samples); };
  // Edges along x and other axes join the even corner to the odd one.
  const auto slanted = [&](std::size_t i, std::size_t j, bool i_is_even) HWY_ATTR {
    const std::size_t e = i_is_even ? i : j;
    const std::size_t o = i_is_even ? j : i;
    const auto at_even = hn::And(hn::Xor(c.row[e], c.next[o]), even);
    const auto at_odd = hn::AndNot(even, hn::Xor(c.next[e], c.row[o]));
    return hn::And(hn::Or(at_even, at_odd), c.in_cells);
  };
  const auto has_y = word_mask(cells.has_row(1, 0));
  const auto has_z = word_mask(cells.has_row(0, 1));
  const auto has_both = hn::And(has_y, has_z);
  const bool y_even = (cells.parity() & 1) == 0;
  const bool z_even = (cells.parity() & 2) == 0;
  const bool is_alike = y_even == z_even;
  put(0, along_x(0));
  put(1, hn::And(across(0, 1), has_y));
  put(2, hn::And(slanted(0, 1, y_even), has_y));
  put(3, hn::And(across(0, 2), has_z));
  put(4, hn::And(slanted(0, 2, z_even), has_z));
  put(5, hn::And(is_alike ? across(0, 3) : across(1, 2), has_both));
  put(6, hn::And(is_alike ? slanted(0, 3, y_even) : slanted(1, 2, !y_even), has_both));
  if constexpr (!kAll) return;
  put(7, hn::And(along_x(1), has_y));
  put(8, hn::And(across(1, 3), has_both));
  put(9, hn::And(slanted(1, 3, z_even), has_both));
  put(10, hn::And(along_x(2), has_z));
  put(11, hn::And(across(2, 3), has_both));
  put(12, hn::And(slanted(2, 3, y_even), has_both));
  put(13, hn::And(along_x(3), has_both));
}

/// The corners of the words' cells by coordinates modulo 2, as in Kuhn's chains.
struct EvenOddCorners {
  EvenOddCorners(const CellRow& cells, const CornerWords& c) {
    const auto even = hn::Set(Words(), 0x55555555U);
    for (std::size_t i = 0; i < 4; ++i) {
      const auto row = c.row[i ^ cells.parity()];
      const auto next = c.next[i ^ cells.parity()];
      corner[2 * i] = hn::Or(hn::And(row, even), hn::AndNot(even, next));
      corner[2 * i + 1] = hn::Or(hn::And(next, even), hn::AndNot(even, row));
    }
  }
  WordsV corner[8];
};

/// Triangles of the words' cells, added up word by word.
HWY_INLINE WordsV n_triangles(const CellRow& cells, const CornerWords& c) {
  const Words d;
  const EvenOddCorners all(cells, c);
  const auto& corner = all.corner;
  auto n = hn::Zero(d);
  const auto across = hn::Xor(corner[0], corner[7]);
  for (const std::size_t first : {1U, 2U, 4U})
    for (const std::size_t second : {1U, 2U, 4U}) {
      if (first == second) continue;
      const auto a = hn::Xor(corner[0], corner[first]);
      const auto b = hn::Xor(corner[0], corner[first | second]);
      const auto crossed = hn::And(hn::Or(hn::Or(a, b), across), c.in_cells);
      // Among four signs, one or three differ from the rest when the differences' sum is odd.
      const auto quads = hn::AndNot(hn::Xor(hn::Xor(a, b), across), crossed);
      n = hn::Add(n, hn::Add(hn::PopulationCount(crossed), hn::PopulationCount(quads)));
    }
  return n;
}

/// In the style of cubes, calls put(series, crossed anchors) for the grid edges, own ones or all.
template <bool kAll, typename Put>
HWY_INLINE void for_each_grid_series(const CellRow& cells, const CornerWords& c, const Put& put) {
  const auto along_x = [&](std::size_t i)
                           HWY_ATTR { return hn::And(hn::Xor(c.row[i], c.next[i]), c.in_cells); };
  const auto across = [&](std::size_t i, std::size_t j)
                          HWY_ATTR { return hn::And(hn::Xor(c.row[i], c.row[j]), c.samples); };
  const auto has_y = word_mask(cells.has_row(1, 0));
  const auto has_z = word_mask(cells.has_row(0, 1));
  put(0, along_x(0));
  put(1, hn::And(across(0, 1), has_y));
  put(3, hn::And(across(0, 2), has_z));
  if constexpr (!kAll) return;
  const auto has_both = hn::And(has_y, has_z);
  put(7, hn::And(along_x(1), has_y));
  put(8, hn::And(across(1, 3), has_both));
  put(10, hn::And(along_x(2), has_z));
  put(11, hn::And(across(2, 3), has_both));
  put(13, hn::And(along_x(3), has_both));
}

/// Of cells in the style of cubes, whose corners are given by differences from the even one.
struct CubePieces {
  explicit CubePieces(const EvenOddCorners& all) {
    for (std::size_t k = 1; k < 8; ++k) differs[k] = hn::Xor(all.corner[0], all.corner[k]);
  }

  /// needs_body_vertex(): the even and the odd corner differ, and of those beside the odd one at
  /// least two more are like the even one than of those beside the even one.
  [[nodiscard]] HWY_INLINE WordsV with_body_vertex() const {
    const auto& x = differs;
    const auto all_low = hn::And(hn::And(x[1], x[2]), x[4]);
    const auto two_low =
        hn::Or(hn::Or(hn::And(x[1], x[2]), hn::And(x[1], x[4])), hn::And(x[2], x[4]));
    const auto any_high = hn::Or(hn::Or(x[3], x[5]), x[6]);
    const auto two_high =
        hn::Or(hn::Or(hn::And(x[3], x[5]), hn::And(x[3], x[6])), hn::And(x[5], x[6]));
    return hn::And(x[7], hn::Or(hn::AndNot(two_high, all_low), hn::AndNot(any_high, two_low)));
  }

  WordsV differs[8];
};

/// Triangles of the words' cells, added up word by word. A disc whose loop has v vertices has v - 2
/// triangles, an annulus v, a fan round a vertex of its own v.
HWY_INLINE WordsV n_cube_triangles(const EvenOddCorners& all, const CubePieces& pieces,
                                   WordsV with_body_vertex, WordsV in_cells) {
  const Words d;
  const auto count = [&](WordsV bits)
                         HWY_ATTR { return hn::PopulationCount(hn::And(bits, in_cells)); };
  auto n = hn::Zero(d);
  for (std::size_t axis = 1; axis < 8; axis *= 2)
    for (std::size_t a = 0; a < 8; ++a)
      if ((a & axis) == 0) n = hn::Add(n, count(hn::Xor(all.corner[a], all.corner[a | axis])));
  // One disc where the body diagonal is crossed; else one round each row of like corners among the
  // six that surround it, and an annulus if all are. Rows begin at most at every second corner.
  const auto& x = pieces.differs;
  const auto begins = [&](std::size_t at, std::size_t before)
                          HWY_ATTR { return hn::AndNot(x[7], hn::AndNot(x[before], x[at])); };
  auto discs =
      count(hn::Or(hn::AndNot(with_body_vertex, x[7]), hn::Or(begins(1, 5), begins(3, 1))));
  discs = hn::Add(discs, count(hn::Or(begins(2, 3), begins(6, 2))));
  discs = hn::Add(discs, count(hn::Or(begins(4, 6), begins(5, 4))));
  return hn::Sub(n, hn::Add(discs, discs));
}

/// Of each own series the vertices, then the triangles.
using RowSums = std::array<std::uint32_t, kOwnSeries + 1>;

/// The sum of each vector's lanes.
HWY_INLINE void put_sums(const WordsV (&v)[kOwnSeries + 1], RowSums& sums) {
  const Words d;
  const hn::Repartition<std::uint64_t, Words> d64;
  // Four vectors' sums side by side in each block of four lanes.
  const auto pair = [&](std::size_t i) HWY_ATTR {
    return hn::BitCast(d64, hn::Add(hn::InterleaveLower(d, v[i], v[i + 1]),
                                    hn::InterleaveUpper(d, v[i], v[i + 1])));
  };
  alignas(64) std::uint32_t blocks[SignField::kPadding];
  const hn::CappedTag<std::uint32_t, 4> d4;
  for (std::size_t i = 0; i < sums.size(); i += 4) {
    const auto low = pair(i);
    const auto high = pair(i + 2);
    hn::Store(hn::Add(hn::BitCast(d, hn::InterleaveLower(d64, low, high)),
                      hn::BitCast(d, hn::InterleaveUpper(d64, low, high))),
              d, blocks);
    auto sum = hn::Load(d4, blocks);
    for (std::size_t k = 4; k < hn::Lanes(d); k += 4) sum = hn::Add(sum, hn::Load(d4, blocks + k));
    hn::StoreU(sum, d4, sums.data() + i);
  }
}

/// False if there is nothing to count.
template <bool kCubes>
HWY_INLINE bool count_in(const CellRow& cells, RowSums& sums) {
  const Words d;
  const auto zero = hn::Zero(d);
  WordsV n[kOwnSeries + 1]{zero, zero, zero, zero, zero, zero, zero, zero};
  WordsV& triangles = n[kOwnSeries];
  const bool has_cells = cells.has_row(1, 1);
  bool is_empty = true;
  for (std::size_t word = 0; word < cells.field().n_words(); word += hn::Lanes(d)) {
    const CornerWords c(cells, word);
    if (c.is_uniform()) continue;
    is_empty = false;
    const auto add = [&](std::size_t s, WordsV crossed)
                         HWY_ATTR { n[s] = hn::Add(n[s], hn::PopulationCount(crossed)); };
    if constexpr (kCubes) {
      for_each_grid_series<false>(cells, c, add);
      if (!has_cells) continue;
      const EvenOddCorners all(cells, c);
      const CubePieces pieces(all);
      const auto with_body_vertex = pieces.with_body_vertex();
      add(6, hn::And(with_body_vertex, c.in_cells));
      triangles = hn::Add(triangles, n_cube_triangles(all, pieces, with_body_vertex, c.in_cells));
    } else {
      for_each_series<false>(cells, c, add);
      if (has_cells) triangles = hn::Add(triangles, n_triangles(cells, c));
    }
  }
  if (!is_empty) put_sums(n, sums);
  return !is_empty;
}

template <bool kCubes>
SliceCounts count_rows(const SignField& field, std::int32_t z, RowStart* starts) {
  SliceCounts all;
  RowSums sums;
  for (std::int32_t y = 0; y < field.dims[1]; ++y) {
    RowStart& start = starts[y];
    if (!field.may_cross(y, z) || !count_in<kCubes>(CellRow(field, y, z), sums)) {
      start.vertex.fill(static_cast<std::uint32_t>(all.vertices));
      start.triangle = static_cast<std::uint32_t>(all.triangles);
      continue;
    }
    for (std::size_t s = 0; s < kOwnSeries; ++s) {
      start.vertex[s] = static_cast<std::uint32_t>(all.vertices);
      all.vertices += sums[s];
    }
    start.triangle = static_cast<std::uint32_t>(all.triangles);
    all.triangles += sums[kOwnSeries];
  }
  return all;
}

void run_place(const RowStart* starts, std::size_t n, const RowStart& base, RowStart* out) {
  constexpr std::size_t kNumbers = sizeof(RowStart) / sizeof(std::uint32_t);
  const hn::CappedTag<std::uint32_t, kNumbers> d;
  const auto* from = reinterpret_cast<const std::uint32_t*>(starts);
  const auto* add = reinterpret_cast<const std::uint32_t*>(&base);
  auto* to = reinterpret_cast<std::uint32_t*>(out);
  for (std::size_t i = 0; i < n * kNumbers; i += kNumbers)
    for (std::size_t k = 0; k < kNumbers; k += hn::Lanes(d))
      hn::StoreU(hn::Add(hn::LoadU(d, from + i + k), hn::LoadU(d, add + k)), d, to + i + k);
}

HWY_INLINE std::uint32_t lanes_that(hn::Mask<Words> mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(Words(), mask, bytes);
  const std::uint32_t bits = bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8;
  return bits & ((std::uint32_t{1} << hn::Lanes(Words())) - 1);
}

/// Cells with corners of both signs.
HWY_INLINE WordsV crossed_cells(const CornerWords& c) {
  const auto any = hn::Or(hn::Or(hn::Or(c.row[0], c.row[1]), hn::Or(c.row[2], c.row[3])),
                          hn::Or(hn::Or(c.next[0], c.next[1]), hn::Or(c.next[2], c.next[3])));
  const auto all = hn::And(hn::And(hn::And(c.row[0], c.row[1]), hn::And(c.row[2], c.row[3])),
                           hn::And(hn::And(c.next[0], c.next[1]), hn::And(c.next[2], c.next[3])));
  return hn::And(hn::AndNot(all, any), c.in_cells);
}

/// Adds what some of a group's words have, from the `first` on.
template <bool kCubes>
HWY_INLINE void find_some(const CellRow& cells, std::size_t first, WordGroup& out) {
  const Words d;
  const CornerWords c(cells, out.first + first);
  if (c.is_uniform()) return;
  auto any = hn::Zero(d);
  const auto put = [&](std::size_t s, WordsV crossed) HWY_ATTR {
    hn::StoreU(crossed, d, out.crossings[s].data() + first);
    any = hn::Or(any, crossed);
    if (s < kOwnSeries) out.with_edges[s] |= lanes_that(hn::Ne(crossed, hn::Zero(d))) << first;
  };
  if constexpr (kCubes) {
    for_each_grid_series<true>(cells, c, put);
    const CubePieces pieces(EvenOddCorners(cells, c));
    put(6, hn::And(hn::And(pieces.with_body_vertex(), c.in_cells), word_mask(cells.has_row(1, 1))));
  } else {
    for_each_series<true>(cells, c, put);
  }
  hn::StoreU(hn::And(crossed_cells(c), word_mask(cells.has_row(1, 1))), d,
             out.cells.data() + first);
  out.met |= lanes_that(hn::Ne(any, hn::Zero(d))) << first;
}

template <bool kCubes>
std::size_t find_in(const CellRow& cells, WordGroup* out) {
  const std::size_t n_words = cells.field().n_words();
  std::size_t n = 0;
  for (std::size_t word = 0; word < n_words; word += WordGroup::kWords) {
    WordGroup& group = out[n];
    group.first = word;
    group.met = 0;
    group.with_edges = {};
    const std::size_t end = std::min(WordGroup::kWords, n_words - word);
    for (std::size_t first = 0; first < end; first += hn::Lanes(Words()))
      find_some<kCubes>(cells, first, group);
    n += group.met != 0 ? 1 : 0;
  }
  return n;
}

SliceCounts run_count(const SignField& field, std::int32_t z, SurfaceStyle style,
                      RowStart* starts) {
  return style == SurfaceStyle::cubes ? count_rows<true>(field, z, starts)
                                      : count_rows<false>(field, z, starts);
}
std::size_t run_find(const CellRow& cells, SurfaceStyle style, WordGroup* out) {
  return style == SurfaceStyle::cubes ? find_in<true>(cells, out) : find_in<false>(cells, out);
}

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {

HWY_EXPORT(run_count);
HWY_EXPORT(run_find);
HWY_EXPORT(run_place);

SliceCounts count_slice(const SignField& field, std::int32_t z, SurfaceStyle style,
                        RowStart* starts) {
  return HWY_DYNAMIC_DISPATCH(run_count)(field, z, style, starts);
}
void place_rows(const RowStart* starts, std::size_t n, const RowStart& base, RowStart* out) {
  HWY_DYNAMIC_DISPATCH(run_place)(starts, n, base, out);
}
std::size_t find_words(const CellRow& row, SurfaceStyle style, WordGroup* out) {
  return HWY_DYNAMIC_DISPATCH(run_find)(row, style, out);
}

}  // namespace lode::diamond
#endif
