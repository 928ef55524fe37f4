#include "lode/models/diamond/brick_nodes.h"

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "lode/models/diamond/range_code.h"
#include "lode/models/diamond/sign_rows.h"

namespace lode::diamond {
namespace {

constexpr auto kRowSamples = as_size(kBrickSamples<3>);
constexpr auto kOddWord = static_cast<std::uint32_t>(BrickNodes::kOdd);

/// The first n bits; n may be negative, or more than there are.
std::uint64_t first_bits(std::int32_t n) {
  return n <= 0 ? 0 : n >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << n) - 1;
}

/// The smallest float32 not below x: f < x and f >= x are what they are of that.
float float_up_of(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) >= x ? f : next_up(f);
}

/// Which of n points first, first + 1, .. of a level's grid, along one axis, are closer to the
/// data's end than their nodes' simplices reach (see Shape::reaches_across()).
std::uint64_t forced_along(std::int32_t last, int level, std::int32_t first, std::int32_t n) {
  const std::int32_t h = std::int32_t{1} << level;
  if (last % (2 * h) == 0) return 0;
  std::uint64_t bits = 0;
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t reach = ((first + i) & 1) != 0 ? 3 * h : 2 * h;
    if (std::abs((first + i) * h - last) < reach) bits |= std::uint64_t{1} << i;
  }
  return bits;
}

}  // namespace

BrickNodes::BrickNodes(const Selection<3>& selection)
    : selection_(selection),
      model_(selection.model()),
      slack_(rounding_slack<3>(model_)),
      top_(std::min(kBrickLevel<3>, model_.shape.n_levels - 1)),
      limits_{selection.tolerance(), float_up_of(selection.relative().above),
              float_up_of(selection.relative().below)} {}

bool BrickNodes::open(const BrickSamples<3>& samples, std::span<const Simplex<3>> simplices) {
  base_ = samples.base();
  data_ = samples.data();
  is_met_ = false;
  const std::size_t whole = stored_at(top_, all_equal<3>(std::int32_t{1} << top_));
  if (simplices.empty() || !selection_.is_active(top_, whole)) return true;
  is_forced_ = false;
  // A part's lattice may begin at an odd multiple of a brick's side: its simplices know.
  top_parity_ = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::int32_t left = model_.shape.dims[i] - 1 - base_[i];
    n_cells_[i] = std::min(left, kBrickEdge<3>);
    is_forced_ = is_forced_ || left < 2 * kBrickEdge<3>;
    if (simplices[0].v[0][i] != base_[i]) top_parity_ |= 1U << i;
  }
  find_levels();
  if (top_ == 0) has_holes_ = selection_.error(top_, whole) == kInfiniteError;
  if (has_holes_) return false;
  is_met_ = true;
  visit_storage_type(model_.storage, [&]<typename T>() { find_inside_samples<T>(); });
  if (finest_ == 0) visit_storage_type(model_.storage, [&]<typename T>() { find_finest<T>(); });
  return true;
}

unsigned BrickNodes::parity_of(int level, const Index<3>& cube) const {
  if (level == top_) return top_parity_;
  unsigned parity = 0;
  for (std::size_t i = 0; i < 3; ++i) parity |= static_cast<unsigned>(cube[i] & 1) << i;
  return parity;
}

template <typename T>
void BrickNodes::find_inside_samples() {
  const std::optional<T> threshold = threshold_of<T>(selection_.isovalue());
  if (!threshold) {
    inside_.fill(0);
    return;
  }
  const T* const samples = reinterpret_cast<const T*>(data_);
  std::array<std::uint32_t, std::tuple_size_v<BrickBits>> words;  // all but a row's last sample
  find_signs({.samples = samples,
              .row_step = kRowSamples,
              .slice_step = kRowSamples * kRowSamples,
              .words = words.data(),
              .word_row_step = 1,
              .word_slice_step = kRowSamples,
              .n_rows = kBrickSamples<3>,
              .n_slices = kBrickSamples<3>},
             *threshold);
  for (std::size_t row = 0; row < words.size(); ++row) {
    const bool is_last_inside = samples[row * kRowSamples + kRowSamples - 1] >= *threshold;
    inside_[row] = words[row] | std::uint64_t{is_last_inside} << (kRowSamples - 1);
  }
}

void BrickNodes::find_levels() {
  for (finest_ = top_; finest_ > 0; --finest_)
    if (!find_level(finest_)) return;
}

bool BrickNodes::find_level(int level) {
  const std::int32_t n = (kBrickEdge<3> >> level) + 1;
  Index<3> first;
  for (std::size_t i = 0; i < 3; ++i) first[i] = base_[i] >> level;
  std::array<std::uint64_t, 3> forced{};
  for (std::size_t i = 0; is_forced_ && i < 3; ++i)
    forced[i] = forced_along(model_.shape.dims[i] - 1, level, first[i], n);
  const Index<3> dims = model_.shape.grid_dims(level);
  const std::int32_t n_x = std::min(n, dims[0] - first[0]);
  std::uint32_t any_of_tier_2 = 0;
  has_holes_ = false;
  LevelBits& bits = levels_[as_size(level)];
  for (std::int32_t z = 0; z < n; ++z)
    for (std::int32_t y = 0; y < n; ++y) {
      std::uint32_t& row = bits[level_word(as_size(y), as_size(z))];
      row = 0;
      if (first[1] + y >= dims[1] || first[2] + z >= dims[2]) continue;
      const bool is_forced = ((forced[1] >> y) & 1) != 0 || ((forced[2] >> z) & 1) != 0;
      row = level_row(level, first + Index<3>{{0, y, z}}, n_x,
                      is_forced ? ~std::uint32_t{0} : static_cast<std::uint32_t>(forced[0]));
      const std::uint32_t n_odd = (as_size(y) & 1) + (as_size(z) & 1);
      if (n_odd == 0) row &= static_cast<std::uint32_t>(kOdd);
      if (model_.has_holes() && row != 0)
        has_holes_ = has_holes_ || is_any_infinite(level, first + Index<3>{{0, y, z}}, row);
      if (n_odd < 2) any_of_tier_2 |= row & static_cast<std::uint32_t>(n_odd == 0 ? kOdd : kEven);
    }
  return any_of_tier_2 != 0;
}

/// `forced`: which are refined whatever their error.
std::uint32_t BrickNodes::level_row(int level, const Index<3>& first, std::int32_t n,
                                    std::uint32_t forced) const {
  if (selection_.has_wanted())
    for (std::int32_t x = 0; x < n; ++x)
      if (selection_.is_wanted((first + Index<3>{{x, 0, 0}}) * (std::int32_t{1} << level)))
        forced |= std::uint32_t{1} << x;
  if (selection_.is_full()) forced = ~std::uint32_t{0};
  const NodeLevel& nodes = model_.levels[as_size(level)];
  const std::size_t at = linear_index<3>(model_.shape.grid_dims(level), first);
  return find_refined({&nodes.error[at], &nodes.low[at], &nodes.high[at], as_size(n)}, limits_,
                      forced);
}

/// `nodes`: bits of a row that begins at `first`.
bool BrickNodes::is_any_infinite(int level, const Index<3>& first, std::uint32_t nodes) const {
  const std::size_t at = linear_index<3>(model_.shape.grid_dims(level), first);
  for (; nodes != 0; nodes &= nodes - 1)
    if (selection_.error(level, at + as_size(std::countr_zero(nodes))) == kInfiniteError)
      return true;
  return false;
}

template <typename T>
void BrickNodes::find_finest() {
  BrickRows rows{};
  find_met_cubes(rows);
  if (selection_.is_full()) {
    refined_.fill(~std::uint64_t{0});
    for (std::size_t z = 0; z < kRowSamples; z += 2)
      for (std::size_t y = 0; y < kRowSamples; y += 2) refined_[brick_row(y, z)] = kOdd;
  } else {
    find_rough(reinterpret_cast<const T*>(data_), {decode_error(selection_.tolerance()), slack_},
               rows, refined_);
    if (is_forced_ || selection_.has_wanted()) add_forced(rows);
  }
  find_refined_cubes();
}

/// And the rows that meet these.
void BrickNodes::find_met_cubes(BrickRows& rows) {
  const std::uint64_t in_data = kOdd & first_bits(n_cells_[0] + 1);
  for (std::size_t k = 0; k < kCubes; ++k)
    for (std::size_t j = 0; j < kCubes; ++j) {
      std::uint64_t any = 0;
      std::uint64_t all = ~std::uint64_t{0};
      for (std::size_t z = 2 * k; z <= 2 * k + 2; ++z)
        for (std::size_t y = 2 * j; y <= 2 * j + 2; ++y) {
          any |= inside_[brick_row(y, z)];
          all &= inside_[brick_row(y, z)];
        }
      any |= any << 1 | any >> 1;
      all &= all << 1 & all >> 1;
      const bool exists = static_cast<std::int32_t>(2 * j) < n_cells_[1] &&
                          static_cast<std::int32_t>(2 * k) < n_cells_[2];
      const std::uint64_t met = exists ? any & ~all & in_data : 0;
      met_[j + kCubes * k] = met;
      if (met == 0) continue;
      for (std::size_t z = 2 * k; z <= 2 * k + 2; ++z) rows[z] |= std::uint64_t{7} << (2 * j);
    }
}

void BrickNodes::add_forced(const BrickRows& rows) {
  constexpr std::int32_t n = kBrickSamples<3>;
  std::array<std::uint64_t, 3> forced{};
  for (std::size_t i = 0; is_forced_ && i < 3; ++i)
    forced[i] = forced_along(model_.shape.dims[i] - 1, 0, base_[i], n);
  for (std::size_t z = 0; z < kRowSamples; ++z)
    for (std::size_t y = 0; y < kRowSamples; ++y) {
      if (((rows[z] >> y) & 1) == 0) continue;
      const bool is_forced = ((forced[1] >> y) & 1) != 0 || ((forced[2] >> z) & 1) != 0;
      std::uint64_t bits = is_forced ? ~std::uint64_t{0} : forced[0];
      if (selection_.has_wanted())
        bits |= selection_.wanted()->row(
            base_ + Index<3>{{0, static_cast<std::int32_t>(y), static_cast<std::int32_t>(z)}}, n);
      if (((y | z) & 1) == 0) bits &= kOdd;
      refined_[brick_row(y, z)] |= bits;
    }
}

void BrickNodes::find_refined_cubes() {
  for (std::size_t k = 0; k < kCubes; ++k)
    for (std::size_t j = 0; j < kCubes; ++j) {
      std::uint64_t& cubes = refined_cubes_[j + kCubes * k];
      cubes = met_[j + kCubes * k];
      if (cubes != 0 && top_ > 0) cubes &= existing_cubes(j, k);
      if (cubes == 0) continue;
      std::uint64_t any = 0;
      for (std::size_t z = 2 * k; z <= 2 * k + 2; ++z)
        for (std::size_t y = 2 * j; y <= 2 * j + 2; ++y) any |= refined_[brick_row(y, z)];
      cubes &= any | any << 1 | any >> 1;
    }
}

/// Cubes of side 2 all of whose simplices there are: those whose three parents are refined. Others
/// have surface only by what samples of holes are taken for.
std::uint64_t BrickNodes::existing_cubes(std::size_t j, std::size_t k) const {
  const std::uint32_t x = refined_of(1, j + (j & 1), k + (k & 1)) & kOddWord;
  const std::uint32_t y = refined_of(1, j + ((j & 1) ^ 1), k + (k & 1)) & ~kOddWord;
  const std::uint32_t z = refined_of(1, j + (j & 1), k + ((k & 1) ^ 1)) & ~kOddWord;
  std::uint64_t cubes = (x | x >> 1) & (y | y >> 1) & (z | z >> 1) & 0xFFFFU;
  // Bit i to bit 2 i + 1.
  cubes = (cubes | cubes << 8) & 0x00FF00FFU;
  cubes = (cubes | cubes << 4) & 0x0F0F0F0FU;
  cubes = (cubes | cubes << 2) & 0x33333333U;
  cubes = (cubes | cubes << 1) & 0x55555555U;
  return cubes << 1;
}

bool BrickNodes::is_refined(int level, const Index<3>& cube) const {
  if (level < finest_) return false;
  const auto x = as_size(2 * cube[0] + 1);
  if (level == 0)
    return ((refined_cubes_[as_size(cube[1]) + kCubes * as_size(cube[2])] >> x) & 1) != 0;
  const std::size_t word = level_word(as_size(2 * cube[1] + 1), as_size(2 * cube[2] + 1));
  return ((levels_[as_size(level)][word] >> x) & 1) != 0;
}

std::uint32_t BrickNodes::crossed_cells(std::size_t y, std::size_t z) const {
  const std::array<std::uint64_t, 4> rows{inside(y, z), inside(y + 1, z), inside(y, z + 1),
                                          inside(y + 1, z + 1)};
  const std::uint64_t any = rows[0] | rows[1] | rows[2] | rows[3];
  const std::uint64_t all = rows[0] & rows[1] & rows[2] & rows[3];
  return static_cast<std::uint32_t>((any | any >> 1) & ~(all & all >> 1) & first_bits(n_cells_[0]));
}

std::array<std::uint64_t, 3> BrickNodes::simplices_along(std::size_t y, std::size_t z) const {
  // The even corner's row, and those beside it in the cells.
  const std::size_t even_y = y + (y & 1);
  const std::size_t even_z = z + (z & 1);
  const std::size_t odd_y = y + ((y & 1) ^ 1);
  const std::size_t odd_z = z + ((z & 1) ^ 1);
  const std::uint64_t x = refined(even_y, even_z) & kOdd;
  const std::uint64_t beside_y = refined(odd_y, even_z) & kEven;
  const std::uint64_t beside_z = refined(even_y, odd_z) & kEven;
  const std::uint64_t cubes = refined_cubes(y / 2, z / 2);
  const std::uint64_t cells = cubes | cubes >> 1;
  return {(x | x >> 1) & cells, (beside_y | beside_y >> 1) & cells,
          (beside_z | beside_z >> 1) & cells};
}

std::size_t BrickNodes::stored_at(int level, const Index<3>& local) const {
  std::size_t at = 0;
  for (std::size_t i = 0; i < 3; ++i)
    at += as_size((base_[i] + local[i]) >> std::max(level, 1)) * model_.strides[as_size(level)][i];
  return at;
}

}  // namespace lode::diamond
