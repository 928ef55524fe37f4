#include "lode/models/diamond/cell_triangles.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/diamond/cell_triangles.cpp"
#define HWY_WANT_AVX3_DL
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace lode::diamond::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

HWY_INLINE std::size_t corners_of(const CornerRows& corners, int x) {
  return (corners[0] >> x & 3) | (corners[1] >> x & 3) << 2 | (corners[2] >> x & 3) << 4 |
         (corners[3] >> x & 3) << 6;
}

/// Where the first vertex of each series is in the starts of four rows, y fastest.
constexpr std::array<std::uint32_t, 16> kStartOfSeries = [] {
  std::array<std::uint32_t, 16> places{};
  for (unsigned row = 0; row < 4; ++row)
    for (unsigned direction = 1; direction < 8; ++direction) {
      if ((direction >> 1 & row) != 0) continue;
      const int series = edge_series(static_cast<int>(direction), static_cast<int>(row & 1),
                                     static_cast<int>(row >> 1));
      places[static_cast<std::size_t>(series)] = 8 * row + direction - 1;
    }
  return places;
}();

/// One cell, edge by edge.
HWY_INLINE std::uint32_t* write_cell(const PerSeries& crossings, const PerSeries& first_id, int x,
                                     const KuhnCubeCase& c, std::uint32_t* out) {
  std::array<std::uint32_t, CellEdges::kEdges> id;
  for (std::size_t e = 0; e < c.n_edges; ++e) {
    const std::size_t series = c.edges[e] & 15;
    const std::uint64_t before = (std::uint64_t{1} << (x + (c.edges[e] >> 4))) - 1;
    id[e] =
        first_id[series] + static_cast<std::uint32_t>(std::popcount(crossings[series] & before));
  }
  for (std::size_t t = 0; t < c.n_triangles; ++t)
    for (const std::uint8_t e : c.triangles[t]) *out++ = id[e];
  return out;
}

/// Those of a word that are marked.
HWY_INLINE std::uint32_t* write_one_by_one(const CellRun& run, std::size_t word,
                                           std::uint32_t cells, const PerSeries& crossings,
                                           const PerSeries& first_id, std::uint32_t* out) {
  const CornerRows corners = run.row->corners(word);
  for (; cells != 0; cells &= cells - 1) {
    const int x = std::countr_zero(cells);
    const KuhnCubeCases& cases = *((x & 1) != 0 ? run.odd : run.even)->by_corners;
    out = write_cell(crossings, first_id, x, cases[corners_of(corners, x)], out);
  }
  return out;
}

#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL

using D32 = hn::CappedTag<std::uint32_t, 16>;
using V32 = hn::Vec<D32>;

/// Each triangle's second and third edge as they are, or exchanged.
alignas(16) constexpr std::uint8_t kTurns[2][16] = {
    {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15},
    {0, 2, 1, 3, 5, 4, 6, 8, 7, 9, 11, 10, 12, 14, 13, 15}};

/// The numbers of the vertices on the edges of a word's cells: 16 at a cell's own x, by series, and
/// as many at the next x.
struct EdgeIds {
  /// `first`: of each series the first one's.
  HWY_INLINE EdgeIds(V32 first, V32 crossings, std::uint32_t x) {
    const D32 d;
    const std::uint64_t before = (std::uint64_t{1} << x) - 1;
    const auto count = [&](std::uint64_t anchors) HWY_ATTR {
      return hn::PopulationCount(
          hn::And(crossings, hn::Set(d, static_cast<std::uint32_t>(anchors))));
    };
    own = hn::Add(first, count(before));
    next = hn::Add(first, count(2 * before + 1));
  }

  V32 own;
  V32 next;
};

/// The corners of a word's cells, by bits: bit k of a cell's byte is the corner whose coordinates
/// are odd along the axes of k.
struct CornerCodes {
  CornerCodes(const CellRow& row, std::size_t word) {
    const CornerRows corners = row.corners(word);
    const auto at = [&](std::size_t i)
                        HWY_ATTR { return static_cast<long long>(corners[i ^ row.parity()]); };
    // Of each row the words at the cells' own x and at the next one; then of even x and of odd x.
    const __m256i own = _mm256_set_epi64x(at(3), at(2), at(1), at(0));
    const __m256i pairs =
        _mm256_mask_blend_epi32(0xAA, own, _mm256_slli_epi64(_mm256_srli_epi64(own, 1), 32));
    const __m256i turned = _mm256_shuffle_epi32(pairs, 0xB1);
    constexpr int kSelect = 0xCA;
    const __m256i words =
        _mm256_ternarylogic_epi32(_mm256_set1_epi32(0x55555555), pairs, turned, kSelect);
    _mm256_store_si256(reinterpret_cast<__m256i*>(codes), bits_by_cell(words));
  }
  alignas(32) std::uint8_t codes[32];

 private:
  /// From eight words of 32 bits to 32 bytes: byte i has the words' bits i.
  static HWY_INLINE __m256i bits_by_cell(__m256i words) {
    // The words' first bytes, then their second ones, ...
    const __m256i in_halves = _mm256_shuffle_epi8(
        words, _mm256_set_epi8(15, 11, 7, 3, 14, 10, 6, 2, 13, 9, 5, 1, 12, 8, 4, 0, 15, 11, 7, 3,
                               14, 10, 6, 2, 13, 9, 5, 1, 12, 8, 4, 0));
    __m256i x = _mm256_permutevar8x32_epi32(in_halves, _mm256_set_epi32(7, 3, 6, 2, 5, 1, 4, 0));
    // Each of the eight by eight bits turned over: in squares of one, of two, of four.
    const auto exchange = [&](auto shift, long long mask) HWY_ATTR {
      constexpr int kXorAnd = 0x28;  // (a ^ b) & c
      constexpr int kXor3 = 0x96;
      const __m256i t = _mm256_ternarylogic_epi64(x, _mm256_srli_epi64(x, shift.value),
                                                  _mm256_set1_epi64x(mask), kXorAnd);
      x = _mm256_ternarylogic_epi64(x, t, _mm256_slli_epi64(t, shift.value), kXor3);
    };
    exchange(std::integral_constant<int, 7>(), 0x00AA00AA00AA00AALL);
    exchange(std::integral_constant<int, 14>(), 0x0000CCCC0000CCCCLL);
    exchange(std::integral_constant<int, 28>(), 0x00000000F0F0F0F0LL);
    return x;
  }
};

/// The crossed cells of a group of words, one after the other.
struct CellList {
  static constexpr std::size_t kMost = 32 * WordGroup::kWords + 32;

  HWY_INLINE void add(const CellRow& row, std::size_t word, std::size_t number,
                      std::uint32_t cells) {
    const CornerCodes all(row, word);
#if HWY_TARGET == HWY_AVX3_DL
    alignas(32) static constexpr std::uint8_t kCount[32] = {
        0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15,
        16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31};
    const auto compress = [&](const std::uint8_t* from, std::uint8_t* to) HWY_ATTR {
      _mm256_storeu_si256(
          (__m256i*)to, _mm256_maskz_compress_epi8(cells, _mm256_load_si256((const __m256i*)from)));
    };
    compress(all.codes, corners + n);
    compress(kCount, x + n);
    _mm256_storeu_si256((__m256i*)(words + n), _mm256_set1_epi8(static_cast<char>(number)));
    n += static_cast<std::size_t>(std::popcount(cells));
#else
    for (; cells != 0; cells &= cells - 1, ++n) {
      x[n] = static_cast<std::uint8_t>(std::countr_zero(cells));
      corners[n] = all.codes[x[n]];
      words[n] = static_cast<std::uint8_t>(number);
    }
#endif
  }

  std::size_t n = 0;
  std::uint8_t corners[kMost];
  std::uint8_t x[kMost];
  std::uint8_t words[kMost];  ///< Their numbers in the group.
};

/// A row of cells, group by group. In one loop over all cells of a group: where each word's ended,
/// a loop of its own would stumble.
template <bool kCubes>
class RowWriter {
 public:
  explicit RowWriter(const CellRun& run)
      : run_(run),
        cases_(cell_cases(run.style)),
        out_(run.out),
        first_id_{_mm512_permutex2var_epi32(hn::LoadU(D32(), run.start->vertex.data()).raw,
                                            hn::LoadU(D32(), kStartOfSeries.data()).raw,
                                            hn::LoadU(D32(), run.above->vertex.data()).raw)} {
    const CellEdges* edges[2] = {run.even, run.odd};
    for (std::size_t i = 0; i < 2; ++i) {
      const bool is_flipped = edges[i]->is_flipped;
      turns_[i] = hn::Load(hn::CappedTag<std::uint8_t, 16>(), kTurns[is_flipped ? 1 : 0]);
      lanes_[i] = hn::Load(hn::CappedTag<std::uint8_t, 32>(), edges[i]->edge.data());
    }
  }

  void write(const WordGroup& group) {
    open(group);
    std::size_t i = 0;
    std::uint32_t* out = out_;
    for (; i < list_.n && run_.end - out >= kMostEnds; ++i) out = write_cell_at(group, i, out);
    out_ = out;
    if (i < list_.n) write_rest(group, i);
  }

 private:
  static constexpr std::ptrdiff_t kMostEnds = 48;
  static constexpr std::size_t kAhead = 512;  ///< Of what is written.

  HWY_INLINE void open(const WordGroup& group) {
    const D32 d;
    list_.n = 0;
    for (std::uint32_t met = group.met; met != 0; met &= met - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(met));
      hn::Store(first_id_, d, first_ids_[i].data());
      list_.add(*run_.row, group.first + i, i, group.cells[i]);
      first_id_ = hn::Add(first_id_, hn::PopulationCount(hn::Load(d, group.crossings[i].data())));
    }
  }

  HWY_INLINE std::uint32_t* write_cell_at(const WordGroup& group, std::size_t i,
                                          std::uint32_t* out) const {
    const D32 d;
    const hn::CappedTag<std::uint8_t, 16> d8;
    const std::size_t x = list_.x[i];
    const std::size_t word = list_.words[i];
    const CellCase& c = cases_[list_.corners[i]];
    const EdgeIds ids(hn::Load(d, first_ids_[word].data()),
                      hn::Load(d, group.crossings[word].data()), static_cast<std::uint32_t>(x));
    const auto turn = turns_[x & 1];
    const auto lanes = lanes_[x & 1];
    const auto put = [&](std::size_t at) HWY_ATTR {
      const auto edges = hn::TableLookupBytes(hn::LoadU(d8, c.edge.data() + at), turn);
      const auto lane = hn::PromoteTo(d, lanes_of(edges, lanes));
      hn::StoreU(V32{_mm512_permutex2var_epi32(ids.own.raw, lane.raw, ids.next.raw)}, d, out + at);
    };
    // Nothing of it is read, but the processor waits for it to be there.
    __builtin_prefetch(out + kAhead, 1);
    put(0);
    if (!kCubes || c.n_ends > 15) put(15);
    if (c.n_ends > 30) put(30);
    return out + c.n_ends;
  }

  /// By a table of 32.
  static HWY_INLINE hn::Vec<hn::CappedTag<std::uint8_t, 16>> lanes_of(
      hn::Vec<hn::CappedTag<std::uint8_t, 16>> edges,
      hn::Vec<hn::CappedTag<std::uint8_t, 32>> table) {
#if HWY_TARGET == HWY_AVX3_DL
    return hn::Vec<hn::CappedTag<std::uint8_t, 16>>{_mm256_castsi256_si128(
        _mm256_permutexvar_epi8(_mm256_castsi128_si256(edges.raw), table.raw))};
#else
    const __m128i low = _mm_shuffle_epi8(_mm256_castsi256_si128(table.raw), edges.raw);
    const __m128i high = _mm_shuffle_epi8(_mm256_extracti128_si256(table.raw, 1), edges.raw);
    const __mmask16 is_high = _mm_test_epi8_mask(edges.raw, _mm_set1_epi8(16));
    return hn::Vec<hn::CappedTag<std::uint8_t, 16>>{_mm_mask_blend_epi8(is_high, low, high)};
#endif
  }

  /// Without writing more than there is.
  void write_rest(const WordGroup& group, std::size_t i) {
    for (; i < list_.n; ++i) {
      const std::size_t word = list_.words[i];
      out_ = write_one_by_one(run_, group.first + word, std::uint32_t{1} << list_.x[i],
                              group.crossings[word], first_ids_[word], out_);
    }
  }

  const CellRun& run_;
  const CellCase* cases_;
  // Where x is even, and odd: of five triangles; and by CellCase's edges those of EdgeIds.
  hn::Vec<hn::CappedTag<std::uint8_t, 16>> turns_[2];
  hn::Vec<hn::CappedTag<std::uint8_t, 32>> lanes_[2];
  std::uint32_t* out_;
  V32 first_id_;
  alignas(64) PerSeries first_ids_[WordGroup::kWords];
  CellList list_;
};

template <bool kCubes>
void write_row(const CellRun& run) {
  RowWriter<kCubes> writer(run);
  for (const WordGroup& group : run.groups) writer.write(group);
}

void run_cells(const CellRun& run) {
  if (run.style == SurfaceStyle::cubes)
    write_row<true>(run);
  else
    write_row<false>(run);
}

#else

void run_cells(const CellRun& run) {
  std::uint32_t* out = run.out;
  PerSeries first_id{};
  for (std::size_t s = 0; s < kEdgeSeries; ++s) {
    const RowStart* rows = kStartOfSeries[s] < 16 ? run.start : run.above;
    first_id[s] = rows[kStartOfSeries[s] % 16 / 8].vertex[kStartOfSeries[s] % 8];
  }
  for (const WordGroup& group : run.groups)
    for (std::uint32_t met = group.met; met != 0; met &= met - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(met));
      const PerSeries& crossings = group.crossings[i];
      out = write_one_by_one(run, group.first + i, group.cells[i], crossings, first_id, out);
      for (std::size_t s = 0; s < kEdgeSeries; ++s)
        first_id[s] += static_cast<std::uint32_t>(std::popcount(crossings[s]));
    }
}

#endif

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {

HWY_EXPORT(run_cells);

void write_cells(const CellRun& run) { HWY_DYNAMIC_DISPATCH(run_cells)(run); }

}  // namespace lode::diamond
#endif
