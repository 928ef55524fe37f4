#include "lode/models/diamond/row_edges.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/diamond/row_edges.cpp"
#define HWY_WANT_AVX3_DL
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <bit>

#include "lode/models/diamond/model.h"

HWY_BEFORE_NAMESPACE();
namespace lode::diamond::HWY_NAMESPACE {

/// Crossed edges of one direction among 32 anchors of a row.
template <typename T>
struct EdgeWord {
  const T* samples;              ///< At the first anchor.
  const EdgeEndsByParity* ends;  ///< Of the direction.
  std::uint32_t place;           ///< The first anchor's, whose x is even.
  std::uint32_t crossed;         ///< By bits.
};

template <typename T>
HWY_INLINE std::size_t gather_one_by_one(const EdgeWord<T>& word, const EdgeLists<T>& out,
                                         std::size_t n) {
  for (std::uint32_t crossed = word.crossed; crossed != 0; crossed &= crossed - 1, ++n) {
    const auto x = static_cast<std::uint32_t>(std::countr_zero(crossed));
    const EdgeEnds& ends = (*word.ends)[x & 1];
    out.first[n] = word.samples[x + ends.first_sample];
    out.second[n] = word.samples[x + ends.second_sample];
    out.place[n] = word.place + x + ends.place;
  }
  return n;
}

#if HWY_TARGET == HWY_AVX3_DL

constexpr std::uint32_t kOdd = 0xAAAAAAAA;

/// Of the samples at 32 anchors, `even` and `odd` apart from them by their parity, those that are
/// marked.
HWY_INLINE void compress(const std::uint8_t* even, const std::uint8_t* odd, std::uint32_t marked,
                         std::uint8_t* to) {
  const __m256i all = _mm256_mask_blend_epi8(kOdd, _mm256_loadu_si256((const __m256i*)even),
                                             _mm256_loadu_si256((const __m256i*)odd));
  _mm256_storeu_si256((__m256i*)to, _mm256_maskz_compress_epi8(marked, all));
}
HWY_INLINE void compress_16(const void* even, const void* odd, std::uint32_t marked, void* to) {
  const __m512i all =
      _mm512_mask_blend_epi16(kOdd, _mm512_loadu_si512(even), _mm512_loadu_si512(odd));
  _mm512_storeu_si512(to, _mm512_maskz_compress_epi16(marked, all));
}
HWY_INLINE void compress(const std::uint16_t* even, const std::uint16_t* odd, std::uint32_t marked,
                         std::uint16_t* to) {
  compress_16(even, odd, marked, to);
}
HWY_INLINE void compress(const std::int16_t* even, const std::int16_t* odd, std::uint32_t marked,
                         std::int16_t* to) {
  compress_16(even, odd, marked, to);
}
HWY_INLINE void compress(const float* even, const float* odd, std::uint32_t marked, float* to) {
  for (std::size_t i = 0; i < 32; i += 16) {
    const auto mask = static_cast<__mmask16>(marked >> i);
    const __m512 all = _mm512_mask_blend_ps(static_cast<__mmask16>(kOdd), _mm512_loadu_ps(even + i),
                                            _mm512_loadu_ps(odd + i));
    _mm512_storeu_ps(to, _mm512_maskz_compress_ps(mask, all));
    to += std::popcount(static_cast<std::uint32_t>(mask));
  }
}
HWY_INLINE void compress(const double* even, const double* odd, std::uint32_t marked, double* to) {
  for (std::size_t i = 0; i < 32; i += 8) {
    const auto mask = static_cast<__mmask8>(marked >> i);
    const __m512d all = _mm512_mask_blend_pd(static_cast<__mmask8>(kOdd), _mm512_loadu_pd(even + i),
                                             _mm512_loadu_pd(odd + i));
    _mm512_storeu_pd(to, _mm512_maskz_compress_pd(mask, all));
    to += std::popcount(static_cast<std::uint32_t>(mask));
  }
}

/// The places of the marked anchors among 32, of which the first is apart from `ends` by `first`.
HWY_INLINE void compress_places(const EdgeEndsByParity& ends, std::uint32_t first,
                                std::uint32_t marked, std::uint32_t* to) {
  alignas(32) static constexpr std::uint8_t kCount[32] = {
      0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15,
      16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31};
  const __m256i anchors =
      _mm256_maskz_compress_epi8(marked, _mm256_load_si256((const __m256i*)kCount));
  const __m256i even = _mm256_set1_epi32(static_cast<int>(first + ends[0].place));
  const __m256i more = _mm256_set1_epi32(static_cast<int>(ends[1].place - ends[0].place));
  const auto put = [&](__m128i eight, std::uint32_t* at) HWY_ATTR {
    const __m256i anchor = _mm256_cvtepu8_epi32(eight);
    __m256i place = _mm256_add_epi32(anchor, even);
    const __mmask8 is_odd = _mm256_test_epi32_mask(anchor, _mm256_set1_epi32(1));
    place = _mm256_mask_add_epi32(place, is_odd, place, more);
    _mm256_storeu_si256((__m256i*)at, place);
  };
  const __m128i low = _mm256_castsi256_si128(anchors);
  put(low, to);
  if (std::popcount(marked) <= 8) [[likely]]
    return;
  put(_mm_srli_si128(low, 8), to + 8);
  const __m128i high = _mm256_extracti128_si256(anchors, 1);
  put(high, to + 16);
  put(_mm_srli_si128(high, 8), to + 24);
}

template <typename T>
HWY_INLINE std::size_t gather(const EdgeWord<T>& word, const EdgeLists<T>& out, std::size_t n) {
  // Where the samples are several vectors, a few of them are found sooner one by one.
  constexpr int kFew = 4;
  if (sizeof(T) > 2 && std::popcount(word.crossed) <= kFew) return gather_one_by_one(word, out, n);
  const EdgeEndsByParity& ends = *word.ends;
  compress(word.samples + ends[0].first_sample, word.samples + ends[1].first_sample, word.crossed,
           out.first + n);
  compress(word.samples + ends[0].second_sample, word.samples + ends[1].second_sample, word.crossed,
           out.second + n);
  compress_places(ends, word.place, word.crossed, out.place + n);
  return n + static_cast<std::size_t>(std::popcount(word.crossed));
}

#else

template <typename T>
HWY_INLINE std::size_t gather(const EdgeWord<T>& word, const EdgeLists<T>& out, std::size_t n) {
  return gather_one_by_one(word, out, n);
}

#endif

template <typename T>
std::size_t gather_row(const AnchorRow<T>& row, const EdgeLists<T>& out) {
  std::size_t n = 0;
  for (std::size_t s = 0; s < kOwnSeries; ++s) {
    if ((row.series >> s & 1) == 0) continue;
    for (const WordGroup& group : row.groups)
      for (std::uint32_t words = group.met; words != 0; words &= words - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(words));
        if (sizeof(T) > 2 && group.crossings[i][s] == 0) continue;
        const std::size_t word = group.first + i;
        EdgeWord<T> edges{row.samples + word * kBrickSize<3>, &(*row.ends)[s],
                          row.place + 32 * static_cast<std::uint32_t>(word), group.crossings[i][s]};
        if (word == row.n_bricks) {
          edges.samples = row.samples + (word - 1) * kBrickSize<3> + kBrickEdge<3>;
          n = gather_one_by_one(edges, out, n);
        } else {
          n = gather(edges, out, n);
        }
      }
  }
  return n;
}

std::size_t gather_u8(const AnchorRow<std::uint8_t>& row, const EdgeLists<std::uint8_t>& out) {
  return gather_row(row, out);
}
std::size_t gather_u16(const AnchorRow<std::uint16_t>& row, const EdgeLists<std::uint16_t>& out) {
  return gather_row(row, out);
}
std::size_t gather_i16(const AnchorRow<std::int16_t>& row, const EdgeLists<std::int16_t>& out) {
  return gather_row(row, out);
}
std::size_t gather_f32(const AnchorRow<float>& row, const EdgeLists<float>& out) {
  return gather_row(row, out);
}
std::size_t gather_f64(const AnchorRow<double>& row, const EdgeLists<double>& out) {
  return gather_row(row, out);
}

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {
namespace {

/// An edge joins the corners of its box whose coordinates are even, and odd, along its axes.
/// `parity`: of its anchor, bit i for axis i.
EdgeEnds make_ends(unsigned direction, unsigned parity) {
  const int last_axis = 31 - std::countl_zero(direction);
  const unsigned same = ((parity >> last_axis) & 1) != 0 ? ~parity : parity;
  Index<3> first;
  Index<3> second;
  for (std::size_t i = 0; i < 3; ++i) {
    first[i] = static_cast<std::int32_t>((direction & same) >> i & 1);
    second[i] = static_cast<std::int32_t>((direction & ~same) >> i & 1);
  }
  return {packed_edge(first[0], first, second - first),
          static_cast<std::uint32_t>(Model<3>::brick_offset(first)),
          static_cast<std::uint32_t>(Model<3>::brick_offset(second))};
}

std::array<EdgeEndsByDirection, 4> make_all_ends() {
  std::array<EdgeEndsByDirection, 4> all;
  for (unsigned parity = 0; parity < 4; ++parity)
    for (unsigned direction = 1; direction < 8; ++direction)
      all[parity][direction - 1] = {make_ends(direction, parity << 1),
                                    make_ends(direction, parity << 1 | 1)};
  return all;
}

}  // namespace

const EdgeEndsByDirection& edge_ends(int parity) {
  static const std::array<EdgeEndsByDirection, 4> kEnds = make_all_ends();
  return kEnds[static_cast<std::size_t>(parity)];
}

HWY_EXPORT(gather_u8);
HWY_EXPORT(gather_u16);
HWY_EXPORT(gather_i16);
HWY_EXPORT(gather_f32);
HWY_EXPORT(gather_f64);

std::size_t gather_edges(const AnchorRow<std::uint8_t>& row, const EdgeLists<std::uint8_t>& out) {
  return HWY_DYNAMIC_DISPATCH(gather_u8)(row, out);
}
std::size_t gather_edges(const AnchorRow<std::uint16_t>& row, const EdgeLists<std::uint16_t>& out) {
  return HWY_DYNAMIC_DISPATCH(gather_u16)(row, out);
}
std::size_t gather_edges(const AnchorRow<std::int16_t>& row, const EdgeLists<std::int16_t>& out) {
  return HWY_DYNAMIC_DISPATCH(gather_i16)(row, out);
}
std::size_t gather_edges(const AnchorRow<float>& row, const EdgeLists<float>& out) {
  return HWY_DYNAMIC_DISPATCH(gather_f32)(row, out);
}
std::size_t gather_edges(const AnchorRow<double>& row, const EdgeLists<double>& out) {
  return HWY_DYNAMIC_DISPATCH(gather_f64)(row, out);
}

}  // namespace lode::diamond
#endif
