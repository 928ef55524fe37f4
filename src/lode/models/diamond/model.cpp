#include "lode/models/diamond/model.h"

#include <utility>

#include "lode/models/diamond/sample_scale.h"

namespace lode::diamond {
namespace {

/// The bricks along one axis that hold coordinate p: one, or two where it is on their border.
struct BrickSpan {
  std::int32_t first, last;
};

template <int D>
BrickSpan bricks_holding(std::int32_t p, std::int32_t n_bricks) {
  const std::int32_t upper = std::min(p / kBrickEdge<D>, n_bricks - 1);
  const bool is_border = upper > 0 && p == upper * kBrickEdge<D>;
  return {is_border ? upper - 1 : upper, upper};
}

/// Calls body(p) for each point of a non-empty box with coordinate 0 held at its lower end.
template <int D, typename F>
void for_each_row(const Index<D>& lower, const Index<D>& upper, const F& body) {
  Index<D> p = lower;
  while (true) {
    body(p);
    std::size_t i = 1;
    for (; i < as_size(D); ++i) {
      if (++p[i] < upper[i]) break;
      p[i] = lower[i];
    }
    if (i == as_size(D)) return;
  }
}

struct BrickStats {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
  std::uint64_t n_holes = 0;
  std::uint64_t n_removed_cells = 0;
};

template <int D>
bool touches_hole(const Model<D>& model, std::size_t brick) {
  if (!is_floating(model.storage) && !model.info.nodata) return false;
  return visit_storage_type(model.storage, [&]<typename T>() {
    const T* values = reinterpret_cast<const T*>(model.brick(brick));
    if (model.info.nodata)
      return std::any_of(values, values + kBrickSize<D>,
                         [&](T v) { return model.is_hole(static_cast<double>(v)); });
    int n_finite = 0;  // counted without a branch, so that the loop is vectorised
    for (std::size_t i = 0; i < kBrickSize<D>; ++i) n_finite += values[i] - values[i] == T(0);
    return n_finite != static_cast<int>(kBrickSize<D>);
  });
}

/// By slice (rows in 2D); those beyond the data repeat the last one.
template <int D>
std::array<SampleRange, as_size(kBrickSamples<D>)> ranges_of_slices(const Model<D>& model,
                                                                    std::size_t brick) {
  constexpr auto kSlices = as_size(kBrickSamples<D>);
  const Index<D> base = point_of<D>(model.brick_dims, brick) * kBrickEdge<D>;
  const auto n_in_data = [&](std::size_t axis) {
    return std::min(kSlices, as_size(model.shape.dims[axis] - base[axis]));
  };
  const std::size_t n = kSlices * (D == 3 ? n_in_data(1) : 1);
  std::array<SampleRange, kSlices> slices;
  visit_storage_type(model.storage, [&]<typename T>() {
    const T* values = reinterpret_cast<const T*>(model.brick(brick));
    for (std::size_t slice = 0; slice < n_in_data(D - 1); ++slice) {
      T low = std::numeric_limits<T>::max();
      T high = std::numeric_limits<T>::lowest();
      for (std::size_t i = 0; i < n; ++i) {
        low = values[i] < low ? values[i] : low;
        high = values[i] > high ? values[i] : high;
      }
      slices[slice] = {static_cast<double>(low), static_cast<double>(high)};
      values += kBrickSize<D> / kSlices;
    }
  });
  for (std::size_t slice = n_in_data(D - 1); slice < kSlices; ++slice)
    slices[slice] = slices[slice - 1];
  return slices;
}

/// Of a brick without holes, whose layers' ranges it finds.
template <int D>
BrickStats find_ranges(Model<D>& model, std::size_t brick) {
  const auto slices = ranges_of_slices<D>(model, brick);
  BrickStats stats;
  for (const SampleRange& slice : slices) {
    stats.min = std::min(stats.min, slice.low);
    stats.max = std::max(stats.max, slice.high);
  }
  if constexpr (D == 3)
    for (std::size_t layer = 0; layer < Model<D>::kLayers; ++layer) {
      SampleRange& range = model.layer_ranges[brick * Model<D>::kLayers + layer];
      range = slices[layer * Model<D>::kLayer];
      for (std::size_t i = 1; i <= Model<D>::kLayer; ++i) {
        range.low = std::min(range.low, slices[layer * Model<D>::kLayer + i].low);
        range.high = std::max(range.high, slices[layer * Model<D>::kLayer + i].high);
      }
    }
  return stats;
}

/// Range and holes of the samples a brick owns: its last layer only where it is the last brick.
template <int D>
BrickStats stats_with_holes(const Model<D>& model, std::size_t brick) {
  const Index<D> b = point_of<D>(model.brick_dims, brick);
  const Index<D> lower = b * kBrickEdge<D>;
  Index<D> upper;
  for (std::size_t i = 0; i < as_size(D); ++i)
    upper[i] = b[i] == model.brick_dims[i] - 1 ? model.shape.dims[i] : lower[i] + kBrickEdge<D>;
  BrickStats stats;
  visit_storage_type(model.storage, [&]<typename T>() {
    for_each_row<D>(lower, upper, [&](const Index<D>& row) {
      const T* values =
          reinterpret_cast<const T*>(model.brick(brick)) + model.brick_offset(row - lower);
      for (std::int32_t x = 0; x < upper[0] - lower[0]; ++x) {
        const auto value = static_cast<double>(values[x]);
        if (model.is_hole(value)) {
          ++stats.n_holes;
          continue;
        }
        stats.min = std::min(stats.min, value);
        stats.max = std::max(stats.max, value);
      }
    });
  });
  if (!model.shape.has_cells()) return stats;
  for (std::size_t i = 0; i < as_size(D); ++i)
    upper[i] = std::min(upper[i], model.shape.dims[i] - 1);
  for_each_row<D>(lower, upper, [&](Index<D> cell) {
    for (; cell[0] < upper[0]; ++cell[0])
      if (model.is_removed_cell(cell)) ++stats.n_removed_cells;
  });
  return stats;
}

template <int D>
void find_stats(Model<D>& model, Threads threads) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<BrickStats> stats(model.n_bricks());
  if constexpr (D == 3)
    model.layer_ranges.assign(model.n_bricks() * Model<D>::kLayers, {-kInfinity, kInfinity});
  parallel_for(model.n_bricks(), threads, 4, [&](std::size_t i, int) {
    const bool has_holes = touches_hole<D>(model, i);
    model.brick_holes[i] = has_holes ? 1 : 0;
    stats[i] = has_holes ? stats_with_holes<D>(model, i) : find_ranges<D>(model, i);
  });
  BrickStats total;
  for (const BrickStats& s : stats) {
    total.min = std::min(total.min, s.min);
    total.max = std::max(total.max, s.max);
    total.n_holes += s.n_holes;
    total.n_removed_cells += s.n_removed_cells;
  }
  const bool is_empty = total.min > total.max;
  model.stats = {.min = is_empty ? 0.0 : total.min + 0.0,  // not -0: which came first says nothing
                 .max = is_empty ? 0.0 : total.max + 0.0,
                 .n_holes = total.n_holes,
                 .n_removed_cells = total.n_removed_cells};
}

template <int D>
void replicate_border(Model<D>& model, std::size_t brick) {
  const Index<D> base = point_of<D>(model.brick_dims, brick) * kBrickEdge<D>;
  Index<D> last;  // local coordinates of the last sample in the data
  Index<D> end;
  bool is_whole = true;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    last[i] = std::min(kBrickEdge<D>, model.shape.dims[i] - 1 - base[i]);
    end[i] = kBrickSamples<D>;
    is_whole = is_whole && last[i] == kBrickEdge<D>;
  }
  if (is_whole) return;
  visit_storage_type(model.storage, [&]<typename T>() {
    T* values = reinterpret_cast<T*>(model.brick(brick));
    for_each_row<D>({}, end, [&](const Index<D>& row) {
      Index<D> from = row;
      for (std::size_t i = 1; i < as_size(D); ++i) from[i] = std::min(row[i], last[i]);
      T* to = values + model.brick_offset(row);
      if (from != row) std::copy_n(values + model.brick_offset(from), last[0] + 1, to);
      std::fill(to + last[0] + 1, to + end[0], to[last[0]]);
    });
  });
}

}  // namespace

template <int D>
Model<D> Model<D>::make(const VolumeInfo& info) {
  Model model;
  model.reset(info);
  return model;
}

template <int D>
void Model<D>::reset(const VolumeInfo& volume) {
  this->set_info(volume);
  strides.clear();
  for (int level = 0; level < shape.n_levels; ++level) {
    const Index<D> dims = shape.attribute_dims(level);
    auto& of_level = strides.emplace_back();
    std::size_t stride = 1;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      of_level[i] = stride;
      stride *= as_size(dims[i]);
    }
  }
  brick_dims = brick_counts<D>(shape);
  resize_anew(samples, n_bricks() * kBrickSize<D> * sample_size());
  brick_holes.assign(n_bricks(), 0);
  layer_ranges.clear();
}

template <int D>
bool Model<D>::has_removed_border_cell() const {
  for (std::size_t axis = 0; axis < as_size(D); ++axis) {
    Index<D> layer;  // its cells
    for (std::size_t i = 0; i < as_size(D); ++i) layer[i] = i == axis ? 1 : shape.dims[i] - 1;
    for (const std::int32_t at : {0, shape.dims[axis] - 2})
      for (std::size_t i = 0; i < n_points<D>(layer); ++i) {
        Index<D> cell = point_of<D>(layer, i);
        cell[axis] = at;
        if (this->is_removed_cell(cell)) return true;
      }
  }
  return false;
}

template <int D>
double Model<D>::base_error() const {
  if (!shape.has_cells()) return 0;
  const int level = shape.n_levels - 1;
  const NodeLevel& top = levels[as_size(level)];
  if (level == 0) return static_cast<double>(decode_error(top.error[0]));
  const std::size_t at = linear_index<D>(shape.grid_dims(level), all_equal<D>(1));
  return static_cast<double>(decode_error(top.error[at]));
}

void widen_samples(ScalarType type, const std::byte* from, std::size_t n, std::byte* to) {
  visit_scalar_type(type, [&]<typename S>() {
    visit_storage_type(type, [&]<typename T>() {
      for (std::size_t i = 0; i < n; ++i) {
        S sample;
        std::memcpy(&sample, from + i * sizeof(S), sizeof(S));
        const T wide = static_cast<T>(+sample);  // + makes numbers of characters
        std::memcpy(to + i * sizeof(T), &wide, sizeof(T));
      }
    });
  });
}

template <int D>
void put_samples(Model<D>& model, const LatticeBox<D>& box, const std::byte* values,
                 Threads threads) {
  const std::size_t size = model.sample_size();
  const Index<D>& lower = box.lower;
  const Index<D>& upper = box.upper;
  Index<D> rows = upper - lower;
  const std::size_t row_bytes = as_size(std::exchange(rows[0], 1)) * size;
  parallel_for(n_points<D>(rows), threads, 256, [&](std::size_t number, int) {
    const Index<D> row = lower + point_of<D>(rows, number);
    const std::byte* from = values + number * row_bytes;
    Index<D> first;
    Index<D> end;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      first[i] = bricks_holding<D>(row[i], model.brick_dims[i]).first;
      end[i] = bricks_holding<D>(i == 0 ? upper[0] - 1 : row[i], model.brick_dims[i]).last + 1;
    }
    for_each_row<D>(first, end, [&](Index<D> b) {
      for (; b[0] < end[0]; ++b[0]) {
        Index<D> local = row - b * kBrickEdge<D>;
        const std::int32_t begin = std::max(lower[0], b[0] * kBrickEdge<D>);
        const std::int32_t stop = std::min(upper[0], b[0] * kBrickEdge<D> + kBrickSamples<D>);
        if (begin >= stop) continue;
        local[0] = begin - b[0] * kBrickEdge<D>;
        std::byte* to =
            model.brick(linear_index<D>(model.brick_dims, b)) + model.brick_offset(local) * size;
        std::memcpy(to, from + as_size(begin - lower[0]) * size, as_size(stop - begin) * size);
      }
    });
  });
}

template <int D>
void fill_beyond_data(Model<D>& model, Threads threads) {
  parallel_for(model.n_bricks(), threads, 4,
               [&](std::size_t i, int) { replicate_border<D>(model, i); });
}

template <int D>
void finish_samples(Model<D>& model, Threads threads) {
  fill_beyond_data<D>(model, threads);
  find_stats<D>(model, threads);
}

Result<void> check_magnitude(const FieldStats& stats) {
  constexpr double kLimit = 0x1p1000;
  for (const double extreme : {stats.min, stats.max})
    if (std::abs(extreme) > kLimit)
      return fail("expected samples of magnitude up to {:.3g}, got {}", kLimit, extreme);
  return {};
}

template <int D, typename V>
void gather_values(const Model<D>& model, const Index<D>& b, std::int32_t margin, V* out) {
  const Index<D> base = b * kBrickEdge<D>;
  const bool mark_holes = model.has_holes();
  const SampleScale<D, V> scale(model);
  const auto converted = [&](auto v) {
    return mark_holes && model.is_hole(static_cast<double>(v)) ? kNoSample<V> : scale.held(v);
  };
  Index<D> lower;
  Index<D> upper;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    lower[i] = -margin;
    upper[i] = kBrickSamples<D> + margin;
  }
  visit_storage_type(model.storage, [&]<typename T>() {
    const T* samples = reinterpret_cast<const T*>(model.samples.data());
    for_each_row<D>(lower, upper, [&](const Index<D>& p) {
      // The row lies in this brick, or, with a margin, in one beside it; beyond those in x, its end
      // repeats. Who asks without a margin may have no other brick.
      Index<D> at = model.clamped(base + p);
      Index<D> brick = b;
      for (std::size_t i = 1; i < as_size(D); ++i) {
        if (at[i] < base[i] || at[i] > base[i] + kBrickEdge<D>)
          brick[i] = std::min(at[i] / kBrickEdge<D>, model.brick_dims[i] - 1);
        at[i] -= brick[i] * kBrickEdge<D>;
      }
      at[0] = 0;
      // Bricks beside each other in x lie one after the other.
      const T* row = samples + linear_index<D>(model.brick_dims, brick) * kBrickSize<D> +
                     model.brick_offset(at);
      constexpr auto kToNext = static_cast<std::ptrdiff_t>(kBrickSize<D>);
      for (std::int32_t x = -margin; x < 0; ++x)
        *out++ = converted(row[b[0] > 0 ? kBrickEdge<D> + x - kToNext : 0]);
      if (mark_holes)
        for (std::int32_t x = 0; x < kBrickSamples<D>; ++x) out[x] = converted(row[x]);
      else
        for (std::int32_t x = 0; x < kBrickSamples<D>; ++x) out[x] = scale.held(row[x]);
      out += kBrickSamples<D>;
      for (std::int32_t x = 1; x <= margin; ++x)
        *out++ = converted(row[b[0] + 1 < model.brick_dims[0] ? kToNext + x : kBrickEdge<D>]);
    });
  });
}

template struct Model<2>;
template struct Model<3>;
template void put_samples<2>(Model<2>&, const LatticeBox<2>&, const std::byte*, Threads);
template void put_samples<3>(Model<3>&, const LatticeBox<3>&, const std::byte*, Threads);
template void fill_beyond_data<2>(Model<2>&, Threads);
template void fill_beyond_data<3>(Model<3>&, Threads);
template void finish_samples<2>(Model<2>&, Threads);
template void finish_samples<3>(Model<3>&, Threads);
template void gather_values<2, Step>(const Model<2>&, const Index<2>&, std::int32_t, Step*);
template void gather_values<3, Step>(const Model<3>&, const Index<3>&, std::int32_t, Step*);
template void gather_values<2, float>(const Model<2>&, const Index<2>&, std::int32_t, float*);
template void gather_values<3, float>(const Model<3>&, const Index<3>&, std::int32_t, float*);
template void gather_values<2, double>(const Model<2>&, const Index<2>&, std::int32_t, double*);
template void gather_values<3, double>(const Model<3>&, const Index<3>&, std::int32_t, double*);

}  // namespace lode::diamond
