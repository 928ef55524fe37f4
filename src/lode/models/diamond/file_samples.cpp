#include "lode/models/diamond/file_samples.h"

#include <cstring>

#include "lode/core/parallel_check.h"
#include "lode/models/diamond/read_region.h"

namespace lode::diamond {

template <int D, typename Field>
Result<void> check_no_holes(const LatticeField<D, Field>& field, const store::Reader& reader,
                            const store::BlockKey& key, std::span<const std::byte> samples) {
  if (!is_floating(field.storage) && !field.info.nodata) return {};
  if (field.has_holes()) return {};
  return visit_storage_type(field.storage, [&]<typename T>() -> Result<void> {
    for (std::size_t i = 0; i + sizeof(T) <= samples.size(); i += sizeof(T)) {
      T sample;
      std::memcpy(&sample, samples.data() + i, sizeof(T));
      if (field.is_hole(static_cast<double>(sample)))
        return fail("{}: {}: expected no holes, as the metadata say, got a sample {}",
                    reader.path(), describe(key), sample);
    }
    return {};
  });
}

template Result<void> check_no_holes(const LatticeField<2, CoarseField<2>>&, const store::Reader&,
                                     const store::BlockKey&, std::span<const std::byte>);
template Result<void> check_no_holes(const LatticeField<3, CoarseField<3>>&, const store::Reader&,
                                     const store::BlockKey&, std::span<const std::byte>);

namespace {

/// Of a block of level kKeptLevel or a coarser one; coarser grids reach farther beyond the data.
template <int D>
void put_kept(const Region<D>& r, const std::byte* from, CoarseField<D>& field) {
  const std::size_t size = field.sample_size();
  const int shift = r.level - kKeptLevel;
  for_each_row<D>(r, [&](Index<D> q, std::int32_t n, std::int32_t stride) {
    for (std::int32_t i = 0; i < n; ++i, q[0] += stride, from += size) {
      const Index<D> at = q * (1 << shift);
      bool exists = true;
      for (std::size_t a = 0; a < as_size(D); ++a) exists = exists && at[a] < field.dims[a];
      if (exists)
        std::memcpy(field.samples.data() + linear_index<D>(field.dims, at) * size, from, size);
    }
  });
}

}  // namespace

template <int D>
Result<void> load_coarse_samples(const store::Reader& reader, Threads threads,
                                 CoarseField<D>& field) {
  if (!field.is_needed()) return {};
  const std::vector<BlockGroup<D>> groups = coarse_blocks<D>(field.shape);
  return check_all(groups.size(), threads, [&](std::size_t i) -> Result<void> {
    if (!groups[i].is_samples) return {};
    const Region<D>& r = groups[i].region;
    LODE_TRY(const auto bytes, read_region<D>(reader, r, Kind::samples, field.sample_size()));
    LODE_CHECK(check_no_holes<D>(field, reader, key_of(Kind::samples, r), bytes));
    put_kept<D>(r, bytes.data(), field);
    return {};
  });
}

template Result<void> load_coarse_samples<2>(const store::Reader&, Threads, CoarseField<2>&);
template Result<void> load_coarse_samples<3>(const store::Reader&, Threads, CoarseField<3>&);

/// The blocks of finer levels that have points in a box.
template <int D>
std::vector<Region<D>> FileSamples<D>::regions_in(const LatticeBox<D>& box) const {
  const Shape<D>& shape = field_.shape;
  std::vector<Region<D>> regions;
  for (int level = std::min(kChunkLevel, shape.n_levels - 1); level >= 0; --level) {
    const Index<D> dims = sample_dims<D>(shape, level);
    LatticeBox<D> blocks;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      const auto block_of = [&](std::int32_t x) {
        return std::min((x >> level) / kBlockEdge<D>, n_blocks<D>(dims[i]) - 1);
      };
      blocks.lower[i] = block_of(box.lower[i]);
      blocks.upper[i] = block_of(box.upper[i] - 1) + 1;
    }
    const Index<D> edges = blocks.upper - blocks.lower;
    for (std::size_t i = 0; i < n_points<D>(edges); ++i) {
      const Region<D> r = region_at<D>(dims, level, blocks.lower + point_of<D>(edges, i),
                                       level == shape.n_levels - 1);
      if (count_points(r) > 0) regions.push_back(r);
    }
  }
  return regions;
}

template <int D>
void FileSamples<D>::put_coarse(const LatticeBox<D>& box, std::byte* out) const {
  if (!field_.is_needed()) return;
  const std::size_t size = field_.sample_size();
  constexpr std::int32_t kStep = 1 << kKeptLevel;
  LatticeBox<D> grid;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    grid.lower[i] = (box.lower[i] + kStep - 1) >> kKeptLevel;
    grid.upper[i] = ((box.upper[i] - 1) >> kKeptLevel) + 1;
    if (grid.lower[i] >= grid.upper[i]) return;
  }
  const Index<D> edges = box.upper - box.lower;
  const Index<D> points = grid.upper - grid.lower;
  for (std::size_t n = 0; n < n_points<D>(points); ++n) {
    const Index<D> q = grid.lower + point_of<D>(points, n);
    std::memcpy(out + linear_index<D>(edges, q * kStep - box.lower) * size,
                field_.samples.data() + linear_index<D>(field_.dims, q) * size, size);
  }
}

template <int D>
template <typename T>
void FileSamples<D>::put_block(const Region<D>& r, const std::byte* from, const LatticeBox<D>& box,
                               std::byte* out) {
  const Index<D> edges = box.upper - box.lower;
  for_each_row<D>(r, [&](const Index<D>& q, std::int32_t n, std::int32_t stride) {
    const std::byte* const row = from;
    from += as_size(n) * sizeof(T);
    Index<D> p = q * (1 << r.level);
    for (std::size_t i = 1; i < as_size(D); ++i)
      if (p[i] < box.lower[i] || p[i] >= box.upper[i]) return;
    const std::int32_t step = stride << r.level;
    const std::int32_t first = std::max(0, (box.lower[0] - p[0] + step - 1) / step);
    if (p[0] + first * step >= box.upper[0]) return;
    const std::int32_t end = std::min(n, (box.upper[0] - 1 - p[0]) / step + 1);
    p[0] += first * step;
    std::byte* to = out + linear_index<D>(edges, p - box.lower) * sizeof(T);
    if (step == 1) {
      std::memcpy(to, row + as_size(first) * sizeof(T), as_size(end - first) * sizeof(T));
      return;
    }
    for (std::int32_t i = first; i < end; ++i, to += as_size(step) * sizeof(T))
      std::memcpy(to, row + as_size(i) * sizeof(T), sizeof(T));
  });
}

template <int D>
Result<void> FileSamples<D>::read(const LatticeBox<D>& box, const Progress& progress,
                                  std::span<std::byte> out) const {
  LODE_EXPECTS(out.size() == n_points<D>(box.upper - box.lower) * field_.sample_size());
  put_coarse(box, out.data());
  const std::vector<Region<D>> regions = regions_in(box);
  return check_all(regions.size(), threads_, [&](std::size_t i) -> Result<void> {
    if (progress.is_cancelled()) return cancelled_error();
    LODE_TRY(const std::size_t at,
             find_region<D>(blocks_.reader(), regions[i], Kind::samples, field_.sample_size()));
    LODE_TRY(const auto bytes, blocks_.block(at));
    visit_storage_type(field_.storage, [&]<typename T>() {
      put_block<T>(regions[i], bytes->data(), box, out.data());
    });
    return {};
  });
}

template class FileSamples<2>;
template class FileSamples<3>;

}  // namespace lode::diamond
