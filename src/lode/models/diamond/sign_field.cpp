#include "lode/models/diamond/sign_field.h"

#include <algorithm>
#include <limits>

namespace lode::diamond {
namespace {

constexpr std::int32_t kEdge = kBrickEdge<3>;
constexpr std::int32_t kHalf = kEdge / 2;
constexpr std::size_t kRow = as_size(kBrickSamples<3>);

/// Those of the first n of 32.
std::uint32_t first_bits(std::int64_t n) {
  if (n >= 32) return ~std::uint32_t{0};
  return n <= 0 ? 0 : (std::uint32_t{1} << n) - 1;
}

}  // namespace

SignFinder::SignFinder(const Selection<3>& selection, SignField& field)
    : selection_(selection),
      model_(selection.model()),
      field_(field),
      level_(std::min(kBrickLevel<3>, model_.shape.n_levels - 1)),
      states_(model_.n_bricks()) {
  field.dims = model_.shape.dims;
  field.brick_dims = model_.brick_dims;
  field.stride = (as_size(field.dims[0]) + 31) / 32 + 1;
  field.words = std::make_unique_for_overwrite<std::uint32_t[]>(
      field.stride * as_size(field.dims[1]) * as_size(field.dims[2]) + SignField::kPadding);
  for (std::size_t i = 0; i < field.stride + SignField::kPadding; ++i) {
    field.sample_bits.push_back(first_bits(field.dims[0] - 32 * static_cast<std::int64_t>(i)));
    field.cell_bits.push_back(first_bits(field.dims[0] - 1 - 32 * static_cast<std::int64_t>(i)));
  }
  field.is_met.resize(model_.n_bricks() / n_x());
  for (std::size_t row = 0; row < field.is_met.size(); ++row) look_at(row);
}

/// Whether the surface may meet each brick of a row, or which side it is on.
void SignFinder::look_at(std::size_t row) {
  for (std::size_t brick = row * n_x(); brick < (row + 1) * n_x(); ++brick) {
    const Index<3> lower = point_of<3>(model_.brick_dims, brick) * kEdge;
    const auto sign = uniform_sign(lower, level_);
    states_[brick] = sign ? (*sign ? State::inside : State::outside) : State::met;
    if (!sign) field_.is_met[row] = 1;
  }
}

std::uint64_t SignFinder::n_met() const {
  return static_cast<std::uint64_t>(std::ranges::count(states_, State::met));
}

void SignFinder::find(std::int32_t begin, std::int32_t end) {
  const auto n_y = as_size(model_.brick_dims[1]);
  const std::size_t layer = as_size(std::min(begin / kEdge, model_.brick_dims[2] - 1));
  for (std::size_t row = layer * n_y; row < (layer + 1) * n_y; ++row) find_row(row, begin, end);
}

/// Of a row of bricks along x, if edges end in it that may be crossed.
void SignFinder::find_row(std::size_t row, std::int32_t begin, std::int32_t end) {
  if (!is_wanted(row)) return;
  for (std::size_t x = 0; x < n_x(); ++x) {
    const Index<3> brick = point_of<3>(model_.brick_dims, row * n_x() + x);
    SampleBox box = samples_of(brick);
    box.n[2] = std::min(end, box.lower[2] + box.n[2]) - begin;
    box.lower[2] = begin;
    if (x == 0) clear(box);
    switch (states_[row * n_x() + x]) {
      case State::outside: break;
      case State::inside: fill(box, ~std::uint32_t{0}); break;
      case State::met: read(brick, box); break;
    }
  }
}

/// Whether it, or one before it along y or z, is met.
bool SignFinder::is_wanted(std::size_t row) const {
  const auto n_y = as_size(model_.brick_dims[1]);
  const std::size_t y_before = row % n_y > 0 ? 1 : 0;
  const std::size_t z_before = row >= n_y ? n_y : 0;
  return (field_.is_met[row] | field_.is_met[row - y_before] | field_.is_met[row - z_before] |
          field_.is_met[row - y_before - z_before]) != 0;
}

SignFinder::SampleBox SignFinder::samples_of(const Index<3>& brick) const {
  SampleBox box;
  for (std::size_t i = 0; i < 3; ++i) {
    box.lower[i] = brick[i] * kEdge;
    const std::int32_t left = model_.shape.dims[i] - box.lower[i];
    // The last brick of an axis also covers the sample on its border.
    box.n[i] = brick[i] + 1 == model_.brick_dims[i] ? left : std::min(left, kEdge);
  }
  return box;
}

/// The one sign of all samples of a cube, up to and with those at its upper sides, where its
/// range tells.
std::optional<bool> SignFinder::uniform_sign(const Index<3>& lower, int level) const {
  Diamond<3> d{lower, level, 0, 7};
  for (std::size_t i = 0; i < 3; ++i) d.centre[i] += d.h();
  const std::size_t at = selection_.index_of(d);
  if (selection_.is_active(level, at)) return {};
  return selection_.is_inside(level, at);
}

/// The rows that a row of bricks has samples in.
void SignFinder::clear(const SampleBox& first) {
  for (std::int32_t z = 0; z < first.n[2]; ++z)
    std::fill_n(words_at(first.lower + Index<3>{{0, 0, z}}), as_size(first.n[1]) * field_.stride,
                std::uint32_t{0});
}

/// `wanted`: bits of the first 32.
void SignFinder::fill(const SampleBox& box, std::uint32_t wanted) {
  const std::uint32_t bits = first_bits(box.n[0]) & wanted;
  for (std::int32_t z = 0; z < box.n[2]; ++z) {
    std::uint32_t* row = words_at(box.lower + Index<3>{{0, 0, z}});
    for (std::int32_t y = 0; y < box.n[1]; ++y, row += field_.stride) {
      row[0] |= bits;
      if (box.n[0] > 32) row[1] = 1;
    }
  }
}

/// By eighths, where the brick has all of them and the level below tells some apart.
void SignFinder::read(const Index<3>& brick, const SampleBox& box) {
  const SampleBox whole = samples_of(brick);
  const auto is_cut = [&](std::size_t axis) { return whole.n[axis] > kHalf + 1; };
  if (level_ != kBrickLevel<3> || !is_cut(0) || !is_cut(1) || !is_cut(2))
    return read_samples(brick, box, SignPart::all);
  for (const std::int32_t z : {0, kHalf})
    for (const std::int32_t y : {0, kHalf}) {
      const Index<3> eighth = whole.lower + Index<3>{{0, y, z}};
      SampleBox part = box;
      for (const std::size_t axis : {1U, 2U}) {
        const bool is_lower = eighth[axis] == whole.lower[axis];
        const std::int32_t end = box.lower[axis] + box.n[axis];
        part.lower[axis] = std::max(box.lower[axis], eighth[axis]);
        part.n[axis] = (is_lower ? std::min(end, eighth[axis] + kHalf) : end) - part.lower[axis];
      }
      if (part.n[1] > 0 && part.n[2] > 0) read_part(brick, part, eighth);
    }
}

void SignFinder::read_part(const Index<3>& brick, const SampleBox& part, const Index<3>& eighth) {
  const auto low = uniform_sign(eighth, level_ - 1);
  const auto high = uniform_sign(eighth + Index<3>{{kHalf, 0, 0}}, level_ - 1);
  if (low.value_or(false)) fill(part, 0xFFFFU);
  if (high.value_or(false)) fill(part, 0xFFFF0000U);
  if (low && high) return;
  read_samples(brick, part, low ? SignPart::high : high ? SignPart::low : SignPart::all);
}

void SignFinder::read_samples(const Index<3>& brick, const SampleBox& part, SignPart wanted) {
  const std::byte* samples = model_.brick(linear_index<3>(model_.brick_dims, brick));
  visit_storage_type(model_.storage, [&]<typename T>() {
    const auto threshold = threshold_of<T>(selection_.isovalue());
    if (!threshold) return;
    const T* first =
        reinterpret_cast<const T*>(samples) + Model<3>::brick_offset(part.lower - brick * kEdge);
    find_signs(SignRows<T>{first, wanted, kRow, kRow * kRow, words_at(part.lower), field_.stride,
                           field_.stride * as_size(field_.dims[1]), part.n[1], part.n[2]},
               *threshold);
    if (part.n[0] == 32) return;
    for (std::int32_t z = 0; z < part.n[2]; ++z)
      for (std::int32_t y = 0; y < part.n[1]; ++y) {
        std::uint32_t* row = words_at(part.lower + Index<3>{{0, y, z}});
        row[0] &= first_bits(part.n[0]);
        if (part.n[0] > 32)
          row[1] = first[Model<3>::brick_offset({{32, y, z}})] >= *threshold ? 1 : 0;
      }
  });
}

std::uint32_t* SignFinder::words_at(const Index<3>& p) const {
  return field_.words.get() + field_.offset(p[1], p[2]) + as_size(p[0] / 32);
}

SignField sign_field(const Selection<3>& selection, Threads threads, std::uint64_t& n_bricks_read) {
  SignField field;
  SignFinder finder(selection, field);
  const Slabs slabs(field.dims[2], Slabs::kUsualEdge);
  parallel_for(slabs.n(), threads, 1,
               [&](std::size_t slab, int) { finder.find(slabs.begin(slab), slabs.end(slab)); });
  n_bricks_read = finder.n_met();
  return field;
}

}  // namespace lode::diamond
