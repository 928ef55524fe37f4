#include "lode/models/diamond/sign_field.h"

#include <atomic>
#include <limits>
#include <optional>

#include "lode/models/diamond/sign_rows.h"

namespace lode::diamond {
namespace {

constexpr std::int32_t kEdge = kBrickEdge<3>;
constexpr std::size_t kRow = as_size(kBrickSamples<3>);

/// The smallest T that is >= isovalue; nothing when every T is smaller.
template <typename T>
std::optional<T> threshold_of(double isovalue) {
  if constexpr (std::is_integral_v<T>) {
    const double up = std::ceil(isovalue);
    if (up > static_cast<double>(std::numeric_limits<T>::max())) return {};
    return static_cast<T>(std::max(up, static_cast<double>(std::numeric_limits<T>::lowest())));
  } else {
    T t = static_cast<T>(isovalue);
    if (static_cast<double>(t) < isovalue)
      t = std::nextafter(t, std::numeric_limits<T>::infinity());
    return t;
  }
}

/// Those of the first n of 32.
std::uint32_t first_bits(std::int64_t n) {
  if (n >= 32) return ~std::uint32_t{0};
  return n <= 0 ? 0 : (std::uint32_t{1} << n) - 1;
}

class SignFinder {
 public:
  SignFinder(const Selection<3>& selection, SignField& field)
      : selection_(selection), model_(selection.model()), field_(field) {}

  void find_brick(const Index<3>& brick) {
    Index<3> lower;
    Index<3> n;
    for (std::size_t i = 0; i < 3; ++i) {
      lower[i] = brick[i] * kEdge;
      const std::int32_t left = model_.shape.dims[i] - lower[i];
      // The last brick of an axis also covers the sample on its border.
      n[i] = brick[i] + 1 == model_.brick_dims[i] ? left : std::min(left, kEdge);
    }
    const auto cover = uniform_sign(lower);
    if (cover)
      fill(lower, n, *cover);
    else
      read(brick, lower, n);
  }
  [[nodiscard]] std::uint64_t n_read() const { return n_read_.load(); }

 private:
  /// The one sign of all samples of a brick, where its range tells.
  std::optional<bool> uniform_sign(const Index<3>& lower) const {
    const int level = std::min(kBrickLevel<3>, model_.shape.n_levels - 1);
    Diamond<3> d{lower, level, 0, 7};
    for (std::size_t i = 0; i < 3; ++i) d.centre[i] += d.h();
    const std::size_t at = selection_.index_of(d);
    if (selection_.is_active(level, at)) return {};
    return selection_.is_inside(level, at);
  }

  void fill(const Index<3>& lower, const Index<3>& n, bool sign) {
    if (!sign) return;
    for (std::int32_t z = 0; z < n[2]; ++z)
      for (std::int32_t y = 0; y < n[1]; ++y) {
        std::uint32_t* row = words_at(lower + Index<3>{{0, y, z}});
        row[0] = first_bits(n[0]);
        if (n[0] > 32) row[1] = 1;
      }
  }

  void read(const Index<3>& brick, const Index<3>& lower, const Index<3>& n) {
    n_read_.fetch_add(1, std::memory_order_relaxed);
    const std::byte* samples = model_.brick(linear_index<3>(model_.brick_dims, brick));
    visit_storage_type(model_.storage, [&]<typename T>() {
      const auto threshold = threshold_of<T>(selection_.isovalue());
      if (!threshold) return;
      const T* first = reinterpret_cast<const T*>(samples);
      find_signs(SignRows<T>{first, kRow, kRow * kRow, words_at(lower), field_.stride,
                             field_.stride * as_size(field_.dims[1]), n[1], n[2]},
                 *threshold);
      if (n[0] == 32) return;
      for (std::int32_t z = 0; z < n[2]; ++z)
        for (std::int32_t y = 0; y < n[1]; ++y) {
          std::uint32_t* row = words_at(lower + Index<3>{{0, y, z}});
          row[0] &= first_bits(n[0]);
          if (n[0] > 32) row[1] = first[Model<3>::brick_offset({{32, y, z}})] >= *threshold ? 1 : 0;
        }
    });
  }

  std::uint32_t* words_at(const Index<3>& p) const {
    return field_.words.data() + field_.offset(p[1], p[2]) + as_size(p[0] / 32);
  }

  const Selection<3>& selection_;
  const Model<3>& model_;
  SignField& field_;
  std::atomic<std::uint64_t> n_read_{0};
};

}  // namespace

SignField sign_field(const Selection<3>& selection, Threads threads, std::uint64_t& n_bricks_read) {
  const Model<3>& model = selection.model();
  SignField field{model.shape.dims, (as_size(model.shape.dims[0]) + 31) / 32 + 1, {}, {}, {}};
  field.words.assign(
      field.stride * as_size(field.dims[1]) * as_size(field.dims[2]) + SignField::kPadding, 0);
  for (std::size_t i = 0; i < field.stride + SignField::kPadding; ++i) {
    field.sample_bits.push_back(first_bits(field.dims[0] - 32 * static_cast<std::int64_t>(i)));
    field.cell_bits.push_back(first_bits(field.dims[0] - 1 - 32 * static_cast<std::int64_t>(i)));
  }
  SignFinder finder(selection, field);
  const auto n_x = as_size(model.brick_dims[0]);
  parallel_for(model.n_bricks() / n_x, threads, 1, [&](std::size_t row, int) {
    for (std::size_t x = 0; x < n_x; ++x)
      finder.find_brick(point_of<3>(model.brick_dims, row * n_x + x));
  });
  n_bricks_read = finder.n_read();
  return field;
}

}  // namespace lode::diamond
