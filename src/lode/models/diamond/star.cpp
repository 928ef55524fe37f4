#include "lode/models/diamond/star.h"

#include <numeric>

namespace lode::diamond {
namespace {

/// All simplices: along the bisected face from one end of the axis to the other, one odd axis after
/// another; then from the centre to the centres of larger faces, one even axis after another, to
/// either side.
template <int D>
Star<D> make_star(const Index<D>& begin) {
  std::vector<int> odd;
  std::vector<int> even;
  for (int i = 0; i < D; ++i) (begin[as_size(i)] != 0 ? odd : even).push_back(i);
  Star<D> star{static_cast<int>(odd.size()), {}};
  do {
    std::sort(even.begin(), even.end());
    do {
      for (std::uint32_t sides = 0; sides < (1U << even.size()); ++sides) {
        Simplex<D> s;
        s.tag = star.tag;
        s.v[0] = begin;
        for (std::size_t j = 0; j < odd.size(); ++j) {
          s.v[j + 1] = s.v[j];
          s.v[j + 1][as_size(odd[j])] *= -1;
        }
        Index<D> p;
        for (std::size_t j = 0; j < even.size(); ++j) {
          p[as_size(even[j])] = ((sides >> j) & 1U) != 0 ? 1 : -1;
          s.v[odd.size() + 1 + j] = p;
        }
        star.simplices.push_back(s);
      }
    } while (std::next_permutation(even.begin(), even.end()));
  } while (std::next_permutation(odd.begin(), odd.end()));
  return star;
}

template <int D>
std::vector<Star<D>> make_stars() {
  std::vector<Star<D>> stars;
  const Index<D> threes = all_equal<D>(3);
  for (std::size_t code = 0; code < power(3, D); ++code)
    stars.push_back(make_star<D>(point_of<D>(threes, code) - all_equal<D>(1)));
  return stars;
}

}  // namespace

template <int D>
const Star<D>& star_of_axis(const Index<D>& step) {
  static const std::vector<Star<D>> kStars = make_stars<D>();
  return kStars[linear_index<D>(all_equal<D>(3), step + all_equal<D>(1))];
}

template const Star<2>& star_of_axis<2>(const Index<2>&);
template const Star<3>& star_of_axis<3>(const Index<3>&);

}  // namespace lode::diamond
