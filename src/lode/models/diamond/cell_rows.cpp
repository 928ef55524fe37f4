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

/// One word of each of some rows, one above the other: those whose y is even come first.
using Words = hn::CappedTag<std::uint32_t, SignField::kRows>;
using WordsV = hn::Vec<Words>;

HWY_INLINE WordsV word_mask(bool all) {
  return hn::Set(Words(), all ? ~std::uint32_t{0} : std::uint32_t{0});
}

/// Where the mask has bits those of `yes`, else those of `no`.
HWY_INLINE WordsV select(WordsV mask, WordsV yes, WordsV no) {
  return hn::Or(hn::And(mask, yes), hn::AndNot(mask, no));
}

/// Rows of cells, from (y, z) on in y, and what there is of them.
struct CellRows {
  CellRows(const SignField& of, std::int32_t y, std::int32_t z)
      : field(of), has_z(z + 1 < of.dims[2]), is_z_even((z & 1) == 0) {
    const Words d;
    low = &of.words[of.offset(0, y, z)];
    high = &of.words[of.offset(0, y, has_z ? z + 1 : z)];
    const auto number = hn::Add(hn::Iota(d, 0), hn::Set(d, static_cast<std::uint32_t>(y)));
    const auto n_rows = static_cast<std::uint32_t>(of.dims[1]);
    const auto all = word_mask(true);
    is_row = hn::IfThenElseZero(hn::Lt(number, hn::Set(d, n_rows)), all);
    has_y = hn::IfThenElseZero(hn::Lt(number, hn::Set(d, n_rows - 1)), all);
    has_both = hn::And(has_y, word_mask(has_z));
    is_odd = hn::Sub(hn::Zero(d), hn::And(number, hn::Set(d, 1)));
    // Where x is even of even rows, and odd of odd ones.
    like_y = hn::Xor(hn::Set(d, 0x55555555U), is_odd);
    like_z = hn::Set(d, is_z_even ? 0x55555555U : 0xAAAAAAAAU);
    is_alike = is_z_even ? hn::Not(is_odd) : is_odd;
  }

  const SignField& field;
  bool has_z;
  bool is_z_even;
  const std::uint32_t* low;   ///< The first word of the first row, and of that in the next slice
  const std::uint32_t* high;  ///< (or the same).
  WordsV is_row, has_y, has_both;  ///< Whether rows are there, and those behind them in y (and z).
  WordsV is_odd;                   ///< In y.
  WordsV is_alike;                 ///< As even or odd in y as in z.
  WordsV like_y, like_z;           ///< Where x is.
};

/// The corners of the cells in one word of rows: of each of four rows the signs at the cells' own
/// x, and at the next one.
struct CornerWords {
  CornerWords(const CellRows& rows, std::size_t word) {
    const Words d;
    const std::size_t step = rows.field.row_stride;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t* from = (i < 2 ? rows.low : rows.high) + word * step + (i & 1);
      row[i] = hn::LoadU(d, from);
      next[i] = hn::Or(hn::ShiftRight<1>(row[i]), hn::ShiftLeft<31>(hn::LoadU(d, from + step)));
    }
    samples = hn::And(rows.is_row, hn::Set(d, rows.field.sample_bits(word)));
    in_cells = hn::And(rows.is_row, hn::Set(d, rows.field.cell_bits(word)));
  }

  /// Whether no edge is crossed. Rows that are not there say nothing.
  [[nodiscard]] HWY_INLINE bool is_uniform(const CellRows& rows) const {
    // With the next slice, and with the next rows.
    const auto own =
        hn::Or(hn::And(hn::Or(hn::Xor(row[0], next[0]), hn::Xor(row[0], next[2])), in_cells),
               hn::And(hn::Xor(row[0], row[2]), samples));
    const auto above =
        hn::Or(hn::And(hn::Or(hn::Xor(row[0], row[1]), hn::Xor(row[0], row[3])), samples),
               hn::And(hn::Or(hn::Xor(row[0], next[1]), hn::Xor(row[0], next[3])), in_cells));
    const Words d;
    return hn::AllTrue(d, hn::Eq(hn::Or(own, hn::And(above, rows.has_y)), hn::Zero(d)));
  }

  WordsV row[4];
  WordsV next[4];
  WordsV samples, in_cells;  ///< Which bits are samples, and at which cells begin.
};

/// Calls put(series, crossed anchors) for the first kOwnSeries of them, or all.
template <bool kAll, typename Put>
HWY_INLINE void for_each_series(const CellRows& rows, const CornerWords& c, const Put& put) {
  const auto along_x = [&](std::size_t i)
                           HWY_ATTR { return hn::And(hn::Xor(c.row[i], c.next[i]), c.in_cells); };
  const auto across = [&](std::size_t i, std::size_t j)
                          HWY_ATTR { return hn::And(hn::Xor(c.row[i], c.row[j]), c.samples); };
  // Edges along x and other axes join the even corner to the odd one: where x is as the mask says
  // from row i to row j.
  const auto slanted = [&](std::size_t i, std::size_t j, WordsV mask) HWY_ATTR {
    return hn::And(select(mask, hn::Xor(c.row[i], c.next[j]), hn::Xor(c.next[i], c.row[j])),
                   c.in_cells);
  };
  const auto has_z = word_mask(rows.has_z);
  const auto unlike_y = hn::Not(rows.like_y);
  put(0, along_x(0));
  put(1, hn::And(across(0, 1), rows.has_y));
  put(2, hn::And(slanted(0, 1, rows.like_y), rows.has_y));
  put(3, hn::And(across(0, 2), has_z));
  put(4, hn::And(slanted(0, 2, rows.like_z), has_z));
  put(5, hn::And(select(rows.is_alike, across(0, 3), across(1, 2)), rows.has_both));
  put(6, hn::And(select(rows.is_alike, slanted(0, 3, rows.like_y), slanted(1, 2, unlike_y)),
                 rows.has_both));
  if constexpr (!kAll) return;
  put(7, hn::And(along_x(1), rows.has_y));
  put(8, hn::And(across(1, 3), rows.has_both));
  put(9, hn::And(slanted(1, 3, rows.like_z), rows.has_both));
  put(10, hn::And(along_x(2), has_z));
  put(11, hn::And(across(2, 3), rows.has_both));
  put(12, hn::And(slanted(2, 3, rows.like_y), rows.has_both));
  put(13, hn::And(along_x(3), rows.has_both));
}

/// The corners of the words' cells by coordinates modulo 2, as in Kuhn's chains.
struct EvenOddCorners {
  EvenOddCorners(const CellRows& rows, const CornerWords& c) {
    const auto even = hn::Set(Words(), 0x55555555U);
    const std::size_t odd_slice = rows.is_z_even ? 0 : 2;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t low = i ^ odd_slice;
      const auto row = select(rows.is_odd, c.row[low ^ 1], c.row[low]);
      const auto next = select(rows.is_odd, c.next[low ^ 1], c.next[low]);
      corner[2 * i] = select(even, row, next);
      corner[2 * i + 1] = select(even, next, row);
    }
  }
  WordsV corner[8];
};

/// Triangles of the words' cells, added up word by word.
HWY_INLINE WordsV n_triangles(const CellRows& rows, const CornerWords& c) {
  const Words d;
  const EvenOddCorners all(rows, c);
  const auto in_cells = hn::And(c.in_cells, rows.has_both);
  const auto& corner = all.corner;
  auto n = hn::Zero(d);
  const auto across = hn::Xor(corner[0], corner[7]);
  for (const std::size_t first : {1U, 2U, 4U})
    for (const std::size_t second : {1U, 2U, 4U}) {
      if (first == second) continue;
      const auto a = hn::Xor(corner[0], corner[first]);
      const auto b = hn::Xor(corner[0], corner[first | second]);
      const auto crossed = hn::And(hn::Or(hn::Or(a, b), across), in_cells);
      // Among four signs, one or three differ from the rest when the differences' sum is odd.
      const auto quads = hn::AndNot(hn::Xor(hn::Xor(a, b), across), crossed);
      n = hn::Add(n, hn::Add(hn::PopulationCount(crossed), hn::PopulationCount(quads)));
    }
  return n;
}

/// In the style of cubes, calls put(series, crossed anchors) for the grid edges, own ones or all.
template <bool kAll, typename Put>
HWY_INLINE void for_each_grid_series(const CellRows& rows, const CornerWords& c, const Put& put) {
  const auto along_x = [&](std::size_t i)
                           HWY_ATTR { return hn::And(hn::Xor(c.row[i], c.next[i]), c.in_cells); };
  const auto across = [&](std::size_t i, std::size_t j)
                          HWY_ATTR { return hn::And(hn::Xor(c.row[i], c.row[j]), c.samples); };
  const auto has_z = word_mask(rows.has_z);
  put(0, along_x(0));
  put(1, hn::And(across(0, 1), rows.has_y));
  put(3, hn::And(across(0, 2), has_z));
  if constexpr (!kAll) return;
  put(7, hn::And(along_x(1), rows.has_y));
  put(8, hn::And(across(1, 3), rows.has_both));
  put(10, hn::And(along_x(2), has_z));
  put(11, hn::And(across(2, 3), rows.has_both));
  put(13, hn::And(along_x(3), rows.has_both));
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

/// Of each own series the vertices, then the triangles, by row.
using RowSums = std::array<std::array<std::uint32_t, SignField::kRows>, kOwnSeries + 1>;

/// False if there is nothing to count.
template <bool kCubes>
HWY_INLINE bool count_in(const CellRows& rows, std::span<const std::uint32_t> words, RowSums& sums,
                         std::size_t first_row) {
  const Words d;
  const auto zero = hn::Zero(d);
  WordsV n[kOwnSeries + 1]{zero, zero, zero, zero, zero, zero, zero, zero};
  WordsV& triangles = n[kOwnSeries];
  bool is_empty = true;
  for (const std::uint32_t word : words) {
    const CornerWords c(rows, word);
    if (c.is_uniform(rows)) continue;
    is_empty = false;
    const auto add = [&](std::size_t s, WordsV crossed)
                         HWY_ATTR { n[s] = hn::Add(n[s], hn::PopulationCount(crossed)); };
    if constexpr (kCubes) {
      for_each_grid_series<false>(rows, c, add);
      const auto in_cells = hn::And(c.in_cells, rows.has_both);
      const EvenOddCorners all(rows, c);
      const CubePieces pieces(all);
      const auto with_body_vertex = pieces.with_body_vertex();
      add(6, hn::And(with_body_vertex, in_cells));
      triangles = hn::Add(triangles, n_cube_triangles(all, pieces, with_body_vertex, in_cells));
    } else {
      for_each_series<false>(rows, c, add);
      triangles = hn::Add(triangles, n_triangles(rows, c));
    }
  }
  for (std::size_t s = 0; s <= kOwnSeries; ++s) hn::StoreU(n[s], d, sums[s].data() + first_row);
  return !is_empty;
}

template <bool kCubes>
SliceCounts count_rows(const SignField& field, std::int32_t z, RowStart* starts) {
  constexpr auto kRows = static_cast<std::int32_t>(SignField::kRows);
  SliceCounts all;
  RowSums sums;
  for (std::int32_t y = 0; y < field.dims[1]; y += kRows) {
    const std::span<const std::uint32_t> words = field.met_words(y, z);
    bool is_empty = true;
    for (std::size_t row = 0; !words.empty() && row < SignField::kRows; row += hn::Lanes(Words()))
      if (count_in<kCubes>(CellRows(field, y + static_cast<std::int32_t>(row), z), words, sums,
                           row))
        is_empty = false;
    const std::int32_t n_rows = std::min(kRows, field.dims[1] - y);
    for (std::int32_t row = 0; row < n_rows; ++row) {
      RowStart& start = starts[y + row];
      if (is_empty) {
        start.vertex.fill(static_cast<std::uint32_t>(all.vertices));
        start.triangle = static_cast<std::uint32_t>(all.triangles);
        continue;
      }
      for (std::size_t s = 0; s < kOwnSeries; ++s) {
        start.vertex[s] = static_cast<std::uint32_t>(all.vertices);
        all.vertices += sums[s][static_cast<std::size_t>(row)];
      }
      start.triangle = static_cast<std::uint32_t>(all.triangles);
      all.triangles += sums[kOwnSeries][static_cast<std::size_t>(row)];
    }
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

/// Cells with corners of both signs.
HWY_INLINE WordsV crossed_cells(const CornerWords& c, WordsV in_cells) {
  const auto any = hn::Or(hn::Or(hn::Or(c.row[0], c.row[1]), hn::Or(c.row[2], c.row[3])),
                          hn::Or(hn::Or(c.next[0], c.next[1]), hn::Or(c.next[2], c.next[3])));
  const auto all = hn::And(hn::And(hn::And(c.row[0], c.row[1]), hn::And(c.row[2], c.row[3])),
                           hn::And(hn::And(c.next[0], c.next[1]), hn::And(c.next[2], c.next[3])));
  return hn::And(hn::AndNot(all, any), in_cells);
}

/// All series of one word of some rows.
struct SeriesWords {
  SeriesWords() {
    for (WordsV& v : series) v = hn::Zero(Words());
  }

  /// Row by row: out(row) is where its 16 go. Each block of four rows, of four series, is turned
  /// over by itself.
  template <typename Out>
  HWY_INLINE void store(const Out& out) const {
    const Words d;
    const hn::Repartition<std::uint64_t, Words> d64;
    constexpr std::size_t kLanes = hn::MaxLanes(d);
    if constexpr (kLanes != 8) {
      alignas(64) std::array<std::uint32_t, SignField::kRows> words;
      for (std::size_t s = 0; s < 16; ++s) {
        hn::Store(series[s], d, words.data());
        for (std::size_t k = 0; k < hn::Lanes(d); ++k) out(k)[s] = words[k];
      }
    } else {
      WordsV turned[4][4];
      for (std::size_t four = 0; four < 4; ++four) {
        const WordsV* v = series + 4 * four;
        const auto pairs = [&](std::size_t i) HWY_ATTR {
          return hn::BitCast(d64, hn::InterleaveLower(d, v[i], v[i + 1]));
        };
        const auto upper_pairs = [&](std::size_t i) HWY_ATTR {
          return hn::BitCast(d64, hn::InterleaveUpper(d, v[i], v[i + 1]));
        };
        turned[four][0] = hn::BitCast(d, hn::InterleaveLower(d64, pairs(0), pairs(2)));
        turned[four][1] = hn::BitCast(d, hn::InterleaveUpper(d64, pairs(0), pairs(2)));
        turned[four][2] = hn::BitCast(d, hn::InterleaveLower(d64, upper_pairs(0), upper_pairs(2)));
        turned[four][3] = hn::BitCast(d, hn::InterleaveUpper(d64, upper_pairs(0), upper_pairs(2)));
      }
      for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t eight = 0; eight < 2; ++eight) {
          const WordsV low = turned[2 * eight][k];
          const WordsV high = turned[2 * eight + 1][k];
          hn::StoreU(hn::ConcatLowerLower(d, high, low), d, out(k) + 8 * eight);
          hn::StoreU(hn::ConcatUpperUpper(d, high, low), d, out(k + 4) + 8 * eight);
        }
    }
  }

  WordsV series[16];
};

/// Adds what one word of some rows has, the first of which is `first_row` of the groups.
template <bool kCubes>
HWY_INLINE void find_some(const CellRows& rows, std::size_t word, std::size_t first_row,
                          RowGroups& out) {
  const Words d;
  const CornerWords c(rows, word);
  if (c.is_uniform(rows)) return;
  SeriesWords all;
  auto any = hn::Zero(d);
  const auto put = [&](std::size_t s, WordsV crossed) HWY_ATTR {
    all.series[s] = crossed;
    any = hn::Or(any, crossed);
  };
  const auto in_cells = hn::And(c.in_cells, rows.has_both);
  if constexpr (kCubes) {
    for_each_grid_series<true>(rows, c, put);
    const CubePieces pieces(EvenOddCorners(rows, c));
    put(6, hn::And(pieces.with_body_vertex(), in_cells));
  } else {
    for_each_series<true>(rows, c, put);
  }
  const std::size_t i = word % WordGroup::kWords;
  all.store([&](std::size_t row)
                HWY_ATTR { return out.of_word(first_row + row, word).crossings[i].data(); });
  alignas(64) std::array<std::uint32_t, SignField::kRows> cells;
  alignas(64) std::array<std::uint32_t, SignField::kRows> met;
  hn::Store(crossed_cells(c, in_cells), d, cells.data());
  hn::Store(any, d, met.data());
  for (std::size_t row = 0; row < hn::Lanes(d); ++row) {
    WordGroup& group = out.of_word(first_row + row, word);
    group.cells[i] = cells[row];
    group.met |= static_cast<std::uint32_t>(met[row] != 0) << i;
  }
}

template <bool kCubes>
void find_in(const SignField& field, std::int32_t y, std::int32_t z, RowGroups& out) {
  out.clear();
  const std::span<const std::uint32_t> words = field.met_words(y, z);
  if (words.empty()) return;
  for (std::size_t row = 0; row < SignField::kRows; row += hn::Lanes(Words())) {
    const CellRows rows(field, y + static_cast<std::int32_t>(row), z);
    for (const std::uint32_t word : words) find_some<kCubes>(rows, word, row, out);
  }
}

SliceCounts run_count(const SignField& field, std::int32_t z, SurfaceStyle style,
                      RowStart* starts) {
  return style == SurfaceStyle::cubes ? count_rows<true>(field, z, starts)
                                      : count_rows<false>(field, z, starts);
}
void run_find(const SignField& field, std::int32_t y, std::int32_t z, SurfaceStyle style,
              RowGroups& out) {
  if (style == SurfaceStyle::cubes)
    find_in<true>(field, y, z, out);
  else
    find_in<false>(field, y, z, out);
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
void find_words(const SignField& field, std::int32_t y, std::int32_t z, SurfaceStyle style,
                RowGroups& out) {
  HWY_DYNAMIC_DISPATCH(run_find)(field, y, z, style, out);
}

}  // namespace lode::diamond
#endif
