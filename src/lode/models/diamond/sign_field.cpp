#include "lode/models/diamond/sign_field.h"

#include <algorithm>
#include <limits>

namespace lode::diamond {
namespace {

constexpr std::int32_t kEdge = kBrickEdge<3>;
constexpr std::size_t kRow = as_size(kBrickSamples<3>);

}  // namespace

SignFinder::SignFinder(const Selection<3>& selection, SignField& field)
    : model_(selection.model()), isovalue_(selection.isovalue()), field_(field) {
  field.resize(model_.shape.dims);
  field.box_dims = model_.brick_dims;
  field.box_dims[2] = static_cast<std::int32_t>(Slabs(field.dims[2], SignField::kLayer).n());
  states_.resize(n_points<3>(field.box_dims));
  field.met.resize(states_.size() / n_x());
  for (std::size_t row = 0; row < field.met.size(); ++row) look_at(row);
}

std::size_t SignFinder::brick_of(std::size_t box) const {
  Index<3> brick = point_of<3>(field_.box_dims, box);
  brick[2] = brick[2] * SignField::kLayer / kEdge;
  return linear_index<3>(model_.brick_dims, brick);
}

/// As far as its range tells.
SignFinder::State SignFinder::state_of(std::size_t box) const {
  if (model_.layer_ranges.empty()) return State::met;
  constexpr std::size_t kLayers = Model<3>::kLayers;
  const std::size_t layer = box / (n_x() * as_size(field_.box_dims[1])) % kLayers;
  const SampleRange& range = model_.layer_ranges[brick_of(box) * kLayers + layer];
  if (range.low >= isovalue_) return State::inside;
  return range.high < isovalue_ ? State::outside : State::met;
}

/// Whether the surface may meet each box of a row, or which side it is on.
void SignFinder::look_at(std::size_t row) {
  for (std::size_t x = 0; x < n_x(); ++x) {
    State& state = states_[row * n_x() + x] = state_of(row * n_x() + x);
    if (state == State::met) field_.met[row].push_back(static_cast<std::uint32_t>(x));
  }
  if (states_[row * n_x() + n_x() - 1] == State::met && field_.n_words() > n_x())
    field_.met[row].push_back(static_cast<std::uint32_t>(n_x()));
}

std::uint64_t SignFinder::n_met() const {
  std::vector<bool> is_met(model_.n_bricks());
  for (std::size_t box = 0; box < states_.size(); ++box)
    if (states_[box] == State::met) is_met[brick_of(box)] = true;
  return static_cast<std::uint64_t>(std::ranges::count(is_met, true));
}

void SignFinder::find(std::int32_t begin, std::int32_t end) {
  Index<3> box;
  box[2] = std::min(begin / SignField::kLayer, field_.box_dims[2] - 1);
  for (box[1] = 0; box[1] < field_.box_dims[1]; ++box[1])
    for (box[0] = 0; box[0] < field_.box_dims[0]; ++box[0])
      if (is_wanted(box)) find_box(box, begin, end);
}

/// Whether it, or one before it along some axes, is met.
bool SignFinder::is_wanted(const Index<3>& box) const {
  for (std::size_t code = 0; code < 8; ++code) {
    Index<3> before = box;
    bool exists = true;
    for (std::size_t i = 0; i < 3; ++i) {
      before[i] -= (code >> i & 1) != 0 ? 1 : 0;
      exists = exists && before[i] >= 0;
    }
    if (exists && states_[linear_index<3>(field_.box_dims, before)] == State::met) return true;
  }
  return false;
}

/// The last box of a row also has the word behind it.
void SignFinder::find_box(const Index<3>& box, std::int32_t begin, std::int32_t end) {
  SampleBox samples{{{box[0] * kEdge, box[1] * kEdge, begin}}, {{0, 0, end - begin}}};
  // The last box of an axis also covers the sample on its border.
  for (std::size_t i = 0; i < 2; ++i) {
    const std::int32_t left = field_.dims[i] - samples.lower[i];
    samples.n[i] = box[i] + 1 == field_.box_dims[i] ? left : std::min(left, kEdge);
  }
  const std::size_t number = linear_index<3>(field_.box_dims, box);
  const bool is_last = box[0] + 1 == field_.box_dims[0];
  for (std::size_t word = as_size(box[0]) + 1; is_last && word < field_.stride; ++word)
    fill(samples, word, 0);
  if (states_[number] == State::met) return read(number, samples);
  const bool is_inside = states_[number] == State::inside;
  fill(samples, as_size(box[0]), is_inside ? SignField::first_bits(samples.n[0]) : 0);
  if (is_inside && samples.n[0] > 32) fill(samples, as_size(box[0]) + 1, 1);
}

void SignFinder::fill(const SampleBox& samples, std::size_t word, std::uint32_t bits) {
  for (std::int32_t z = 0; z < samples.n[2]; ++z)
    std::fill_n(&field_.words[field_.offset(word, samples.lower[1], samples.lower[2] + z)],
                samples.n[1], bits);
}

void SignFinder::read(std::size_t box, const SampleBox& samples) {
  const std::size_t brick = brick_of(box);
  const bool is_last = (box + 1) % n_x() == 0;
  const std::size_t next = is_last || states_[box + 1] != State::met ? 0 : kBrickSize<3>;
  const Index<3> local = samples.lower - point_of<3>(model_.brick_dims, brick) * kEdge;
  const std::size_t word = box % n_x();
  visit_storage_type(model_.storage, [&]<typename T>() {
    const auto threshold = threshold_of<T>(isovalue_);
    if (!threshold) return fill(samples, word, 0);
    const T* first =
        reinterpret_cast<const T*>(model_.brick(brick)) + Model<3>::brick_offset(local);
    find_signs(SignRows<T>{first, kRow, kRow * kRow,
                           &field_.words[field_.offset(word, samples.lower[1], samples.lower[2])],
                           1, field_.stride * field_.row_stride, samples.n[1], samples.n[2], next},
               *threshold);
    if (samples.n[0] == 32) return;
    for (std::int32_t z = 0; z < samples.n[2]; ++z)
      for (std::int32_t y = 0; y < samples.n[1]; ++y) {
        std::uint32_t* row =
            &field_.words[field_.offset(word, samples.lower[1] + y, samples.lower[2] + z)];
        row[0] &= SignField::first_bits(samples.n[0]);
        if (samples.n[0] > 32)
          row[field_.row_stride] =
              first[Model<3>::brick_offset({{32, y, z}})] >= *threshold ? 1 : 0;
      }
  });
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
