#include "lode/models/diamond/file_parts.h"

#include "lode/core/parallel_check.h"
#include "lode/core/parallel_fill.h"
#include "lode/models/diamond/block_checks.h"
#include "lode/models/diamond/error_pass.h"
#include "lode/models/diamond/file_samples.h"
#include "lode/models/diamond/read_region.h"

namespace lode::diamond {
namespace {

template <int D>
Result<void> load_coarse_nodes(const store::Reader& reader, const Region<D>& r,
                               CoarseField<D>& field) {
  NodeLevel& nodes = field.levels[as_size(r.level)];
  const Index<D> dims = field.shape.grid_dims(r.level);
  LODE_TRY(const auto errors, read_region<D>(reader, r, Kind::errors, sizeof(ErrorCode)));
  for_each_value<ErrorCode>(r, dims, errors.data(),
                            [&](std::size_t at, ErrorCode e) { nodes.error[at] = e; });
  return visit_range_type(field.storage, [&]<typename R>() -> Result<void> {
    LODE_TRY(const auto lows, read_region<D>(reader, r, Kind::lows, sizeof(R)));
    LODE_TRY(const auto highs, read_region<D>(reader, r, Kind::highs, sizeof(R)));
    for_each_value<R>(r, dims, lows.data(),
                      [&](std::size_t at, R v) { nodes.low[at] = static_cast<float>(v); });
    for_each_value<R>(r, dims, highs.data(),
                      [&](std::size_t at, R v) { nodes.high[at] = static_cast<float>(v); });
    return {};
  });
}

/// Compares the errors that the metadata promise with those of the levels that are there.
template <int D>
Result<void> check_errors(const store::Reader& reader, const Summary& said,
                          const CoarseField<D>& field) {
  LODE_CHECK(check_said(reader, "base error", said.base_error, field.base_error()));
  for (std::size_t level = as_size(kKeptLevel); level < field.levels.size(); ++level)
    LODE_CHECK(check_said(reader, fmt::format("largest error of level {}", level),
                          said.max_errors[level], largest_error(field.levels[level])));
  return {};
}

/// n values to x, x + step, ... of a row of `dim`, of those that lie in it.
template <typename T>
void copy_spaced(const std::byte* from, std::int32_t n, std::int32_t x, std::int32_t step,
                 std::int32_t dim, std::byte* row) {
  const std::int32_t first = x < 0 ? (-x + step - 1) / step : 0;
  const std::int32_t end = x < dim ? std::min(n, (dim - 1 - x) / step + 1) : 0;
  if (first >= end) return;
  from += as_size(first) * sizeof(T);
  std::byte* to = row + as_size(x + first * step) * sizeof(T);
  if (step == 1) {
    std::memcpy(to, from, as_size(end - first) * sizeof(T));
    return;
  }
  for (std::int32_t i = first; i < end; ++i) {
    std::memcpy(to, from, sizeof(T));
    from += sizeof(T);
    to += as_size(step) * sizeof(T);
  }
}

}  // namespace

template <int D>
Result<CoarseField<D>> load_coarse(const store::Reader& reader, const Metadata& metadata,
                                   Threads threads) {
  auto field = CoarseField<D>::make(metadata.info);
  field.stats = metadata.summary.stats;
  if (!field.is_needed()) return field;
  const std::vector<BlockGroup<D>> groups = coarse_blocks<D>(field.shape);
  LODE_CHECK(load_coarse_samples<D>(reader, threads, field));
  LODE_CHECK(check_all(groups.size(), threads, [&](std::size_t i) {
    return groups[i].is_samples ? Result<void>()
                                : load_coarse_nodes<D>(reader, groups[i].region, field);
  }));
  for (NodeLevel& nodes : field.levels) LODE_CHECK(check_nodes(nodes, reader, threads));
  LODE_CHECK(check_errors<D>(reader, metadata.summary, field));
  return field;
}

template <int D>
std::uint64_t FilePart<D>::n_bytes(const VolumeInfo& info) {
  const Shape<D> whole = shape_of<D>(info.grid.dims);
  Index<D> dims;  // a brick more below the chunk, and above it
  for (std::size_t i = 0; i < as_size(D); ++i)
    dims[i] = std::min(whole.dims[i], kChunkEdge<D> + 2 * kBrickEdge<D> + 1);
  const Shape<D> shape = Shape<D>::of(dims);
  constexpr std::uint64_t kNodeBytes = sizeof(ErrorCode) + 2 * sizeof(float);
  std::uint64_t bytes = n_points<D>(brick_counts<D>(shape)) * kBrickSize<D> + n_points<D>(dims);
  bytes *= size_of(storage_type(info.type));
  for (int level = 0; level < std::min(whole.n_levels, kBrickLevel<D> + 1); ++level)
    bytes += n_points<D>(shape.attribute_dims(level)) * kNodeBytes;
  return bytes;
}

/// Beyond the chunk a whole brick: where the part ends inside the data, its last sample is then a
/// multiple of a brick's edge, so that no node of its bricks seems to reach across it.
template <int D>
LatticeBox<D> FilePart<D>::samples_of(const PartPlan<D>& plan) const {
  const LatticeBox<D> core = samples_of_chunks<D>(field_.shape, plan.chunks);
  LatticeBox<D> samples = plan.samples;
  for (std::size_t i = 0; i < as_size(D); ++i)
    samples.upper[i] = std::min(field_.shape.dims[i], core.upper[i] + kBrickEdge<D> + 1);
  return samples;
}

template <int D>
void FilePart<D>::begin(const Index<D>& chunk, int first_level) {
  plan_ = PartPlan<D>::of(field_.shape, {chunk, chunk + all_equal<D>(1)});
  plan_.samples = samples_of(plan_);
  VolumeInfo info = field_.info;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    plan_.dims[i] = plan_.samples.upper[i] - plan_.part.origin[i];
    info.grid.dims[as_size(field_.axes.axis[i])] = plan_.dims[i];
  }
  flat_.set_info(info);
  flat_.stats = field_.stats;
  flat_.samples.resize(n_points<D>(plan_.dims) * field_.sample_size());
  model_.reset(info);
  model_.stats = field_.stats;
  model_.levels.resize(as_size(std::min(field_.shape.n_levels, kBrickLevel<D> + 1)));
  for (std::size_t level = as_size(first_level); level < model_.levels.size(); ++level) {
    const std::size_t n = n_points<D>(model_.shape.attribute_dims(static_cast<int>(level)));
    NodeLevel& nodes = model_.levels[level];
    fill_anew(nodes.error, n, ErrorCode{0}, threads_);
    fill_anew(nodes.low, n, std::numeric_limits<float>::infinity(), threads_);
    fill_anew(nodes.high, n, -std::numeric_limits<float>::infinity(), threads_);
  }
}

template <int D>
void FilePart<D>::take_coarse_samples() {
  if (!field_.is_needed()) return;
  const std::size_t size = field_.sample_size();
  const Index<D> origin = plan_.part.origin;
  Index<D> points;
  for (std::size_t i = 0; i < as_size(D); ++i) points[i] = ((plan_.dims[i] - 1) >> kKeptLevel) + 1;
  for (std::size_t n = 0; n < n_points<D>(points); ++n) {
    const Index<D> q = point_of<D>(points, n);
    Index<D> from = q;
    for (std::size_t i = 0; i < as_size(D); ++i) from[i] += origin[i] >> kKeptLevel;
    std::memcpy(flat_.samples.data() + linear_index<D>(plan_.dims, q * (1 << kKeptLevel)) * size,
                field_.samples.data() + linear_index<D>(field_.dims, from) * size, size);
  }
}

template <int D>
void FilePart<D>::take_coarse_nodes() {
  const Index<D> origin = plan_.part.origin;
  for (std::size_t level = as_size(kKeptLevel); level < model_.levels.size(); ++level) {
    NodeLevel& to = model_.levels[level];
    const NodeLevel& from = field_.levels[level];
    const Index<D> here = model_.shape.grid_dims(static_cast<int>(level));
    const Index<D> there = field_.shape.grid_dims(static_cast<int>(level));
    for (std::size_t at = 0; at < to.error.size(); ++at) {
      Index<D> q = point_of<D>(here, at);
      bool exists = true;
      for (std::size_t i = 0; i < as_size(D); ++i) {
        q[i] += origin[i] >> level;
        exists = exists && q[i] < there[i];
      }
      if (!exists) continue;
      const std::size_t place = linear_index<D>(there, q);
      to.error[at] = from.error[place];
      to.low[at] = from.low[place];
      to.high[at] = from.high[place];
    }
  }
}

template <int D>
std::vector<Region<D>> FilePart<D>::regions_near(Kind kind, int level, const LatticeBox<D>& samples,
                                                 std::span<const Index<D>> bricks,
                                                 std::int32_t margin) const {
  const bool is_samples = kind == Kind::samples;
  const Index<D> dims =
      is_samples ? sample_dims<D>(field_.shape, level) : field_.shape.grid_dims(level);
  const Index<D> n = block_counts<D>(dims);
  LatticeBox<D> all;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    const std::int32_t edge = kBlockEdge<D> << level;
    all.lower[i] = std::min(samples.lower[i] / edge, n[i] - 1);
    all.upper[i] = std::min(samples.upper[i] / edge, n[i] - 1) + 1;
  }
  std::vector<Region<D>> regions;
  const Index<D> edges = all.upper - all.lower;
  for (std::size_t i = 0; i < n_points<D>(edges); ++i) {
    const Region<D> r = region_at<D>(dims, level, all.lower + point_of<D>(edges, i),
                                     is_samples && level == field_.shape.n_levels - 1);
    const auto is_near = [&](const Index<D>& brick) {
      for (std::size_t a = 0; a < as_size(D); ++a) {
        const std::int32_t lower = brick[a] * kBrickEdge<D> - margin;
        if (((r.upper[a] - 1) << level) < lower ||
            (r.lower[a] << level) > lower + kBrickEdge<D> + 2 * margin)
          return false;
      }
      return true;
    };
    if (count_points(r) > 0 && std::any_of(bricks.begin(), bricks.end(), is_near))
      regions.push_back(r);
  }
  return regions;
}

/// Calls put(place on the part's own level's grid, value) for the points of blocks that are near.
template <int D>
template <typename T, typename Put>
Result<void> FilePart<D>::read_kind(Kind kind, int level, std::span<const Index<D>> bricks,
                                    std::int32_t margin, const Put& put) {
  const std::vector<Region<D>> regions = regions_near(kind, level, plan_.samples, bricks, margin);
  Index<D> origin = plan_.part.origin;
  for (std::int32_t& x : origin.v) x >>= level;
  return check_all(regions.size(), threads_, [&](std::size_t i) -> Result<void> {
    const Region<D>& r = regions[i];
    LODE_TRY(const std::size_t at, find_region<D>(blocks_.reader(), r, kind, sizeof(T)));
    LODE_TRY(const auto bytes, blocks_.block(at));
    if (kind == Kind::samples)
      LODE_CHECK(check_no_holes<D>(field_, blocks_.reader(), key_of(kind, r), *bytes));
    const std::byte* from = bytes->data();
    for_each_row<D>(r, [&](Index<D> q, std::int32_t n, std::int32_t stride) {
      q = q - origin;
      put(q, n, stride, from);
      from += as_size(n) * sizeof(T);
    });
    return {};
  });
}

template <int D>
Result<void> FilePart<D>::read_attributes(int level, std::span<const Index<D>> bricks) {
  NodeLevel& nodes = model_.levels[as_size(level)];
  const Index<D> dims = model_.shape.grid_dims(level);
  const auto reads = [&]<typename T>(Kind kind, auto& array) {
    return read_kind<T>(
        kind, level, bricks, 0,
        [&](const Index<D>& q, std::int32_t n, std::int32_t stride, const std::byte* from) {
          for (std::size_t i = 1; i < as_size(D); ++i)
            if (q[i] < 0 || q[i] >= dims[i]) return;
          for (std::int32_t i = 0, x = q[0]; i < n; ++i, x += stride) {
            if (x < 0 || x >= dims[0]) continue;
            Index<D> at = q;
            at[0] = x;
            T value;
            std::memcpy(&value, from + as_size(i) * sizeof(T), sizeof(T));
            array[linear_index<D>(dims, at)] =
                static_cast<typename std::remove_cvref_t<decltype(array)>::value_type>(value);
          }
        });
  };
  LODE_CHECK(reads.template operator()<ErrorCode>(Kind::errors, nodes.error));
  const auto ranges = visit_range_type(field_.storage, [&]<typename R>() -> Result<void> {
    LODE_CHECK(reads.template operator()<R>(Kind::lows, nodes.low));
    return reads.template operator()<R>(Kind::highs, nodes.high);
  });
  if (!ranges) return ranges.error();
  return check_nodes(nodes, blocks_.reader(), threads_);
}

template <int D>
Result<void> FilePart<D>::read_samples(int level, std::span<const Index<D>> bricks) {
  return visit_storage_type(field_.storage, [&]<typename T>() {
    return read_kind<T>(
        Kind::samples, level, bricks, kMargin,
        [&](const Index<D>& q, std::int32_t n, std::int32_t stride, const std::byte* from) {
          Index<D> p = q;
          for (std::int32_t& x : p.v) x *= 1 << level;
          for (std::size_t i = 1; i < as_size(D); ++i)
            if (p[i] < 0 || p[i] >= plan_.dims[i]) return;
          const std::int32_t x = std::exchange(p[0], 0);
          std::byte* const row = flat_.samples.data() + linear_index<D>(plan_.dims, p) * sizeof(T);
          copy_spaced<T>(from, n, x, stride << level, plan_.dims[0], row);
        });
  });
}

template <int D>
void FilePart<D>::will_load(const Index<D>& chunk, std::span<const Index<D>> fine) const {
  if (fine.empty()) return;
  const LatticeBox<D> samples =
      samples_of(PartPlan<D>::of(field_.shape, {chunk, chunk + all_equal<D>(1)}));
  const auto ask = [&](Kind kind, int level, std::int32_t margin) {
    for (const Region<D>& r : regions_near(kind, level, samples, fine, margin))
      if (const auto at = blocks_.reader().find(key_of(kind, r))) blocks_.will_need(*at);
  };
  for (int level = coarsest_in_blocks(); level >= 0; --level) {
    if (level > 0)
      for (const Kind kind : {Kind::errors, Kind::lows, Kind::highs}) ask(kind, level, 0);
    ask(Kind::samples, level, kMargin);
  }
}

/// Copies a brick's samples out of the flat ones; beyond the data the nearest ones.
template <int D>
void FilePart<D>::fill_brick(const Index<D>& local) {
  const std::size_t size = field_.sample_size();
  const Index<D> base = local * kBrickEdge<D>;
  Index<D> rows = all_equal<D>(kBrickSamples<D>);
  rows[0] = 1;
  std::byte* brick = model_.brick(linear_index<D>(model_.brick_dims, local));
  const std::int32_t n = std::min(kBrickSamples<D>, plan_.dims[0] - base[0]);
  for (std::size_t r = 0; r < n_points<D>(rows); ++r) {
    const Index<D> row = point_of<D>(rows, r);
    const Index<D> p = flat_.clamped(base + row);
    std::byte* to = brick + model_.brick_offset(row) * size;
    const std::byte* from = flat_.samples.data() + linear_index<D>(plan_.dims, p) * size;
    std::memcpy(to, from, as_size(n) * size);
    for (std::int32_t x = n; x < kBrickSamples<D>; ++x)
      std::memcpy(to + as_size(x) * size, from + as_size(n - 1) * size, size);
  }
}

/// Of its samples those of level kKeptLevel. Beyond the data these are what the field has kept: the
/// nearest samples are of finer levels, and were not read.
template <int D>
void FilePart<D>::fill_coarse_brick(const Index<D>& local) {
  const Index<D> base = local * kBrickEdge<D> + plan_.part.origin;
  std::byte* const brick = model_.brick(linear_index<D>(model_.brick_dims, local));
  const Index<D> points = all_equal<D>((kBrickEdge<D> >> kKeptLevel) + 1);
  visit_storage_type(field_.storage, [&]<typename T>() {
    for (std::size_t i = 0; i < n_points<D>(points); ++i) {
      const Index<D> p = point_of<D>(points, i) * (1 << kKeptLevel);
      const T sample = static_cast<T>(field_.value(base + p));
      std::memcpy(brick + static_cast<std::size_t>(model_.brick_offset(p)) * sizeof(T), &sample,
                  sizeof(T));
    }
  });
}

template <int D>
std::vector<std::uint8_t> FilePart<D>::find_near_fine() const {
  std::vector<std::uint8_t> is_near(model_.n_bricks(), 0);
  for (const Index<D>& brick : fine_)
    for (std::size_t code = 0; code < power(3, D); ++code) {
      const Index<D> b = brick + point_of<D>(all_equal<D>(3), code) - all_equal<D>(1);
      bool exists = true;
      for (std::size_t i = 0; i < as_size(D); ++i)
        exists = exists && b[i] >= 0 && b[i] < model_.brick_dims[i];
      if (exists) is_near[linear_index<D>(model_.brick_dims, b)] = 1;
    }
  return is_near;
}

/// They have samples as far as kMargin goes.
template <int D>
void FilePart<D>::fill_beside() {
  const std::vector<std::uint8_t> is_near = find_near_fine();
  parallel_for(is_near.size(), threads_, 1, [&](std::size_t i, int) {
    if (is_near[i] != 0) fill_brick(point_of<D>(model_.brick_dims, i));
  });
}

/// Fills the bricks beside those that are wanted too, and marks those that have holes: what cells
/// are removed at a brick's border depends on both sides.
template <int D>
void FilePart<D>::find_holes() {
  const std::vector<std::uint8_t> is_near = find_near_fine();
  parallel_for(is_near.size(), threads_, 1, [&](std::size_t i, int) {
    if (is_near[i] == 0) return;
    fill_brick(point_of<D>(model_.brick_dims, i));
    model_.brick_holes[i] = visit_storage_type(field_.storage, [&]<typename T>() {
      const T* samples = reinterpret_cast<const T*>(model_.brick(i));
      const bool has_hole = std::any_of(samples, samples + kBrickSize<D>, [&](T sample) {
        return field_.is_hole(static_cast<double>(sample));
      });
      return static_cast<std::uint8_t>(has_hole ? 1 : 0);
    });
  });
}

/// A brick's samples with one layer round them, as gather_values() gives them.
template <int D>
template <typename C>
void FilePart<D>::gather(const Index<D>& local, C* out) const {
  const Index<D> base = local * kBrickEdge<D> - all_equal<D>(1);
  Index<D> rows = all_equal<D>(kLeafEdge<D>);
  rows[0] = 1;
  const bool has_holes = field_.has_holes();
  const bool is_inside = base[0] >= 0 && base[0] + kLeafEdge<D> <= plan_.dims[0];
  visit_storage_type(field_.storage, [&]<typename T>() {
    const T* samples = reinterpret_cast<const T*>(flat_.samples.data());
    for (std::size_t r = 0; r < n_points<D>(rows); ++r) {
      Index<D> p = flat_.clamped(base + point_of<D>(rows, r));
      p[0] = 0;
      const T* row = samples + linear_index<D>(plan_.dims, p);
      if (is_inside && !has_holes) {
        const T* const inside = row + base[0];
        for (std::int32_t x = 0; x < kLeafEdge<D>; ++x) out[x] = static_cast<C>(inside[x]);
        out += kLeafEdge<D>;
        continue;
      }
      for (std::int32_t x = 0; x < kLeafEdge<D>; ++x) {
        const T sample = row[std::clamp(base[0] + x, 0, plan_.dims[0] - 1)];
        const bool is_hole = has_holes && field_.is_hole(static_cast<double>(sample));
        *out++ = is_hole ? kNoSample<C> : static_cast<C>(sample);
      }
    }
  });
}

template <int D>
template <typename C>
void FilePart<D>::find_leaf_attributes(std::span<const Index<D>> bricks) {
  diamond::find_leaf_attributes<C>(
      model_, bricks.size(), threads_, [&](std::size_t i) { return to_local(bricks[i]); },
      [&](const Index<D>& brick, C* values) { gather(brick, values); });
}

template <int D>
void FilePart<D>::set_fine(std::span<const Index<D>> bricks) {
  fine_.clear();
  for (const Index<D>& brick : bricks) fine_.push_back(to_local(brick));
}

/// A brick of the field, numbered as one of the part's.
template <int D>
Index<D> FilePart<D>::to_local(const Index<D>& brick) const {
  Index<D> local = brick;
  for (std::size_t a = 0; a < as_size(D); ++a) local[a] -= plan_.part.origin[a] / kBrickEdge<D>;
  return local;
}

template <int D>
Result<void> FilePart<D>::load(const Index<D>& chunk, std::span<const Index<D>> fine,
                               std::span<const Index<D>> coarse) {
  begin(chunk, fine.empty() && field_.is_needed() ? kKeptLevel : 0);
  set_fine(fine);
  take_coarse_samples();
  if (field_.is_needed()) take_coarse_nodes();
  for (int level = coarsest_in_blocks(); level >= 0 && !fine.empty(); --level) {
    if (level > 0) LODE_CHECK(read_attributes(level, fine));
    LODE_CHECK(read_samples(level, fine));
  }
  parallel_for(fine.size(), threads_, 1,
               [&](std::size_t i, int) { fill_brick(to_local(fine[i])); });
  parallel_for(coarse.size(), threads_, 1,
               [&](std::size_t i, int) { fill_coarse_brick(to_local(coarse[i])); });
  if (field_.has_holes()) find_holes();
  if (is_exact_in_float<D>(field_))
    find_leaf_attributes<float>(fine);
  else
    find_leaf_attributes<double>(fine);
  return {};
}

template <int D>
Result<void> FilePart<D>::load_samples(const Index<D>& chunk, std::span<const Index<D>> fine) {
  begin(chunk, kBrickLevel<D> + 1);
  set_fine(fine);
  take_coarse_samples();
  for (int level = coarsest_in_blocks(); level >= 0; --level) LODE_CHECK(read_samples(level, fine));
  return {};
}

template Result<CoarseField<2>> load_coarse<2>(const store::Reader&, const Metadata&, Threads);
template Result<CoarseField<3>> load_coarse<3>(const store::Reader&, const Metadata&, Threads);
template class FilePart<2>;
template class FilePart<3>;

}  // namespace lode::diamond
