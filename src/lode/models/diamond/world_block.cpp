#include "lode/models/diamond/world_block.h"

#include <bit>
#include <cmath>
#include <type_traits>

namespace lode::diamond {
namespace {

/// What vectors of C are masked with.
template <typename C>
using BitsOf = std::conditional_t<sizeof(C) == 4, std::uint32_t, std::uint64_t>;

/// By place: all bits set where the halves of two coordinates have not the same parity. Of points
/// with odd coordinates: where those leave other rests when divided by 4.
template <int D, typename C>
const BitsOf<C>* differing_halves(std::size_t i, std::size_t j, std::int32_t edge,
                                  std::size_t size) {
  static const auto kAll = [&] {
    std::array<std::vector<BitsOf<C>>, 9> all;
    const Index<D> edges = all_equal<D>(edge);
    for (std::size_t a = 0; a < as_size(D); ++a)
      for (std::size_t b = 0; b < as_size(D); ++b) {
        auto& bits = all[3 * a + b];
        bits.resize(size);
        for (std::size_t at = 0; at < n_points<D>(edges); ++at) {
          const Index<D> half = point_of<D>(edges, at);
          bits[at] = ((half[a] ^ half[b]) & 1) != 0 ? ~BitsOf<C>{0} : 0;
        }
      }
    return all;
  }();
  return kAll[3 * i + j].data();
}

}  // namespace

template <int D, typename C>
WorldScale<D, C>::WorldScale(const Vec<double, as_size(D)>& spacing) {
  double all = 0;
  for (const double s : spacing.v) all += s * s;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    constexpr double kMost = 0x1p76;  // squares of integers that C holds stay finite
    face[i] = static_cast<C>(std::min(all / (spacing[i] * spacing[i]), kMost));
    outward[i] = 4 * face[i];
  }
  edge = 2 * std::sqrt(all);
  for (std::uint32_t odd = 1; odd < power(2, D); ++odd) {
    double axis = 0;
    for (std::size_t i = 0; i < as_size(D); ++i)
      if ((odd >> i & 1U) != 0) axis += 4 * spacing[i] * spacing[i];
    longest[odd] = static_cast<C>(std::min(1.0, std::sqrt(std::max(axis, all)) / edge));
  }
}

template <int D, typename C>
WorldBlock<D, C>::WorldBlock(const WorldScale<D, C>& scale) : scale_(scale) {
  for (auto* array : {&values_, &errors_, &worlds_}) array->assign(power(2, D) * kSize, C(0));
}

template <int D, typename C>
template <typename V>
void WorldBlock<D, C>::put(const V* from, std::int32_t edge, std::int32_t first,
                           UninitializedArray<C>& to) {
  ApartRows<C> rows;
  rows.stride = kEdge;
  const std::int32_t n_planes = D == 3 ? edge : 1;
  for (std::int32_t plane = 0; plane < n_planes; ++plane) {
    for (const std::int32_t y : {0, 1})
      for (const std::int32_t x : {0, 1}) {
        Index<D> p = all_equal<D>(first);
        p[0] += x;
        p[1] += y;
        if constexpr (D == 3) p[2] += plane;
        rows.to[as_size(y)][as_size(x)] = to.data() + place(p);
      }
    take_apart(from, as_size(edge), as_size(edge), rows);
    from += std::ptrdiff_t{edge} * edge;
  }
}

template <int D, typename C>
template <typename V>
void WorldBlock<D, C>::put_values(const V* values) {
  put(values, kWorldSamples<D>, -1, values_);
}

template <int D, typename C>
template <typename V>
void WorldBlock<D, C>::put_errors(const V* errors) {
  put(errors, kWorldNodes<D>, 0, errors_);
}

template <int D, typename C>
void WorldBlock<D, C>::hide_outside(const Index<D>& lower, const Index<D>& upper) {
  for (std::size_t axis = 0; axis < as_size(D); ++axis) {
    Index<D> layer = all_equal<D>(kWorldSamples<D>);
    layer[axis] = 1;
    for (const std::int32_t x : {lower[axis] - 1, upper[axis] + 1}) {
      if (x < -1 || x > kWorldNodes<D>) continue;
      for (std::size_t i = 0; i < n_points<D>(layer); ++i) {
        Index<D> p = point_of<D>(layer, i) - all_equal<D>(1);
        p[axis] = x;
        values_[place(p)] = std::numeric_limits<C>::quiet_NaN();
      }
    }
  }
}

template <int D, typename C>
WorldKind<C> WorldBlock<D, C>::kind_of(std::uint32_t odd) const {
  WorldKind<C> kind;
  kind.n_axes = as_size(D);
  kind.n_odd = as_size(std::popcount(odd));
  std::size_t n = 0;
  for (const std::uint32_t is_odd : {1U, 0U})
    for (std::size_t i = 0; i < as_size(D); ++i)
      if ((odd >> i & 1U) == is_odd) kind.axes[n++] = i;
  Index<D> first;
  Index<D> last = all_equal<D>(kWorldNodes<D> - 1);
  for (std::size_t i = 0; i < as_size(D); ++i)
    if ((odd >> i & 1U) != 0) {
      ++first[i];
      --last[i];
    }
  kind.begin = static_cast<std::ptrdiff_t>(place(first));
  kind.end = static_cast<std::ptrdiff_t>(place(last)) + 1;
  kind.origin =
      kind.begin / static_cast<std::ptrdiff_t>(kSize) * static_cast<std::ptrdiff_t>(kSize);
  for (std::size_t code = 0; code < power(3, D); ++code) {
    const Index<D> step = point_of<D>(all_equal<D>(3), code) - all_equal<D>(1);
    // Where D is 2 the third step is 0.
    kind.near[code + (D == 2 ? 9 : 0)] =
        static_cast<std::ptrdiff_t>(place(first + step)) - kind.begin;
  }
  for (std::size_t i = 1; i < kind.n_odd; ++i) {
    const BitsOf<C>* bits = differing_halves<D, C>(kind.axes[0], kind.axes[i], kEdge, kSize);
    kind.is_mirrored[i - 1] = bits;
  }
  for (std::size_t i = 0; i < as_size(D); ++i) {
    kind.face[i] = scale_.face[i];
    kind.outward[i] = scale_.outward[i];
  }
  kind.longest = scale_.longest[odd];
  return kind;
}

template <int D, typename C>
void WorldBlock<D, C>::find(bool is_nested) {
  for (int n_odd = 1; n_odd <= D; ++n_odd)
    for (std::uint32_t odd = 1; odd < power(2, D); ++odd)
      if (std::popcount(odd) == n_odd)
        find_worlds(kind_of(odd), values_.data(), errors_.data(), worlds_.data(), is_nested);
}

template struct WorldScale<2, float>;
template struct WorldScale<3, float>;
template struct WorldScale<2, double>;
template struct WorldScale<3, double>;
template class WorldBlock<2, float>;
template class WorldBlock<3, float>;
template class WorldBlock<2, double>;
template class WorldBlock<3, double>;
template void WorldBlock<2, float>::put_values(const float*);
template void WorldBlock<3, float>::put_values(const float*);
template void WorldBlock<2, double>::put_values(const double*);
template void WorldBlock<3, double>::put_values(const double*);
template void WorldBlock<2, float>::put_values(const Step*);
template void WorldBlock<3, float>::put_values(const Step*);
template void WorldBlock<2, float>::put_errors(const float*);
template void WorldBlock<3, float>::put_errors(const float*);
template void WorldBlock<2, double>::put_errors(const double*);
template void WorldBlock<3, double>::put_errors(const double*);
template void WorldBlock<2, float>::put_errors(const Step*);
template void WorldBlock<3, float>::put_errors(const Step*);

}  // namespace lode::diamond
