#include "lode/models/diamond/field_scan.h"

#include <limits>
#include <numeric>
#include <optional>

namespace lode::diamond {
namespace {

struct SliceStats {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
  std::uint64_t n_holes = 0;
};

/// Of samples among which is no hole.
template <typename T>
SliceStats range_of(const T* values, std::size_t n) {
  T low = values[0];
  T high = values[0];
  for (std::size_t i = 0; i < n; ++i) {
    low = values[i] < low ? values[i] : low;
    high = values[i] > high ? values[i] : high;
  }
  return {static_cast<double>(low), static_cast<double>(high), 0};
}

template <typename T>
bool all_finite(const T* values, std::size_t n) {
  if constexpr (std::is_integral_v<T>) return true;
  std::size_t n_finite = 0;  // counted without a branch, so that the loop is vectorised
  for (std::size_t i = 0; i < n; ++i) n_finite += values[i] - values[i] == T(0) ? 1 : 0;
  return n_finite == n;
}

/// The value that means a hole, as a sample; none where no sample is that.
template <typename T>
std::optional<T> nodata_as(const std::optional<double>& nodata) {
  if (!nodata) return {};
  if (!(*nodata >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
        *nodata <= static_cast<double>(std::numeric_limits<T>::max())))
    return {};
  const T value = static_cast<T>(*nodata);
  if (static_cast<double>(value) != *nodata) return {};
  return value;
}

/// Marks the holes with 1, all other samples with 0. Without branches, so that the loops are
/// vectorised.
template <typename T>
SliceStats stats_of(const T* values, std::size_t n, const std::optional<T>& nodata,
                    std::uint8_t* holes) {
  const bool has_nodata = nodata.has_value();
  const T hole = nodata.value_or(T(0));
  std::size_t n_holes = 0;
  for (std::size_t i = 0; i < n; ++i) {
    bool is_hole = has_nodata & (values[i] == hole);
    if constexpr (!std::is_integral_v<T>) is_hole |= !(values[i] - values[i] == T(0));
    holes[i] = is_hole ? 1 : 0;
    n_holes += is_hole ? 1 : 0;
  }
  SliceStats stats;
  stats.n_holes = n_holes;
  if (n_holes == n) return stats;
  T low = std::numeric_limits<T>::max();
  T high = std::numeric_limits<T>::lowest();
  for (std::size_t i = 0; i < n; ++i) {
    low = holes[i] == 0 && values[i] < low ? values[i] : low;
    high = holes[i] == 0 && values[i] > high ? values[i] : high;
  }
  stats.min = static_cast<double>(low);
  stats.max = static_cast<double>(high);
  return stats;
}

}  // namespace

template <int D>
FieldScan<D>::FieldScan(const VolumeInfo& info) {
  field_.set_info(info);
  slice_dims_ = field_.shape.dims;
  slice_dims_[as_size(D - 1)] = 1;
  slice_size_ = n_points<D>(slice_dims_);
  can_have_holes_ = is_floating(field_.storage) || info.nodata.has_value();
}

template <int D>
void FieldScan<D>::put(std::int32_t begin, std::int32_t end, const std::byte* values,
                       Threads threads) {
  const auto n_slices = as_size(end - begin);
  if (n_slices == 0) return;
  std::vector<SliceStats> stats(n_slices);
  holes_.resize(can_have_holes_ ? (n_slices + 1) * slice_size_ : 0);
  parallel_for(n_slices, threads, 1, [&](std::size_t slice, int) {
    visit_storage_type(field_.storage, [&]<typename T>() {
      const T* first = reinterpret_cast<const T*>(values) + slice * slice_size_;
      std::uint8_t* holes = can_have_holes_ ? holes_.data() + (slice + 1) * slice_size_ : nullptr;
      if (!field_.info.nodata && all_finite(first, slice_size_)) {
        stats[slice] = range_of(first, slice_size_);
        if (holes != nullptr) std::fill_n(holes, slice_size_, std::uint8_t{0});
        return;
      }
      stats[slice] = stats_of(first, slice_size_, nodata_as<T>(field_.info.nodata), holes);
    });
  });
  for (const SliceStats& s : stats) {
    n_holes_ += s.n_holes;
    if (s.min > s.max) continue;
    min_ = is_empty_ ? s.min : std::min(min_, s.min);
    max_ = is_empty_ ? s.max : std::max(max_, s.max);
    is_empty_ = false;
  }
  if (!can_have_holes_) return;
  std::vector<std::uint64_t> removed(n_slices);
  parallel_for(n_slices, threads, 1, [&](std::size_t slice, int) {
    const std::uint64_t n_before = slice == 0 ? n_holes_in_last_ : stats[slice - 1].n_holes;
    if ((slice == 0 && !has_last_) || n_before + stats[slice].n_holes == 0) return;
    const std::uint8_t* first = holes_.data() + slice * slice_size_;
    removed[slice] = count_removed(first, first + slice_size_);
  });
  n_removed_ = std::accumulate(removed.begin(), removed.end(), n_removed_);
  std::copy_n(holes_.data() + n_slices * slice_size_, slice_size_, holes_.data());
  n_holes_in_last_ = stats.back().n_holes;
  has_last_ = true;
}

/// Cells between two slices that touch a hole.
template <int D>
std::uint64_t FieldScan<D>::count_removed(const std::uint8_t* slice,
                                          const std::uint8_t* next) const {
  const auto width = as_size(slice_dims_[0]);
  const std::size_t n_rows = slice_size_ / width;  // of cells, one less where there are several
  const std::size_t above = D == 3 ? width : 0;
  std::vector<std::uint8_t> touched(width);
  std::uint64_t n = 0;
  for (std::size_t row = 0; row + (D == 3 ? 1 : 0) < n_rows; ++row) {
    const std::size_t first = row * width;
    for (std::size_t x = 0; x < width; ++x)
      touched[x] =
          slice[first + x] | slice[first + above + x] | next[first + x] | next[first + above + x];
    std::size_t n_here = 0;
    for (std::size_t x = 0; x + 1 < width; ++x) n_here += touched[x] | touched[x + 1];
    n += n_here;
  }
  return n;
}

template <int D>
FieldStats FieldScan<D>::stats() const {
  return {.min = is_empty_ ? 0.0 : min_ + 0.0,  // not -0: which of the two came first says nothing
          .max = is_empty_ ? 0.0 : max_ + 0.0,
          .n_holes = n_holes_,
          .n_removed_cells = field_.shape.has_cells() ? n_removed_ : 0};
}

template class FieldScan<2>;
template class FieldScan<3>;

}  // namespace lode::diamond
