#include "bench/layout/rivals.h"

#include <algorithm>
#include <cstring>

#include "lode/store/codec.h"

namespace lode::bench {
namespace {

constexpr std::uint64_t kPageBytes = 4096;

/// Calls body(p) for all points of a box, x fastest.
template <typename Body>
void for_each_point(const IndexBox& box, const Body& body) {
  for (std::int32_t z = box.lower[2]; z < box.upper[2]; ++z)
    for (std::int32_t y = box.lower[1]; y < box.upper[1]; ++y)
      for (std::int32_t x = box.lower[0]; x < box.upper[0]; ++x) body(Index3{{x, y, z}});
}

/// How many are in different places of a file, where neighbours in the set mostly share one.
template <typename Place>
std::uint64_t count_places(const SampleSet& samples, std::size_t n_places, const Place& place) {
  std::vector<bool> is_touched(n_places);
  for (std::size_t i = 0; i < samples.is_in().size(); ++i)
    if (samples.is_in()[i]) is_touched[place(i)] = true;
  return static_cast<std::uint64_t>(std::ranges::count(is_touched, true));
}

}  // namespace

SampleSet::SampleSet(const Index3& dims)
    : dims_(dims), is_in_(static_cast<std::size_t>(IndexBox{{}, dims}.n_samples())) {}

std::size_t SampleSet::index_of(const Index3& p) const {
  return static_cast<std::size_t>(p[0] +
                                  std::int64_t{dims_[0]} * (p[1] + std::int64_t{dims_[1]} * p[2]));
}

SampleSet crossed_cells(const Volume& volume, double isovalue, const IndexBox& box) {
  SampleSet set(volume.info.grid.dims);
  visit_scalar_type(volume.info.type, [&]<typename T>() {
    const auto samples = volume.as<T>();
    IndexBox cells = box;
    for (std::size_t i = 0; i < 3; ++i) --cells.upper[i];
    for_each_point(cells, [&](const Index3& cell) {
      int n_inside = 0;
      const IndexBox corners{cell, cell + Index3{{2, 2, 2}}};
      for_each_point(corners, [&](const Index3& p) {
        n_inside += static_cast<double>(samples[set.index_of(p)]) >= isovalue ? 1 : 0;
      });
      if (n_inside != 0 && n_inside != 8)
        for_each_point(corners, [&](const Index3& p) { set.add(p); });
    });
  });
  return set;
}

PlainBricks::PlainBricks(const Volume& volume, std::int32_t edge) : edge_(edge) {
  const Index3 dims = volume.info.grid.dims;
  const std::size_t size = size_of(volume.info.type);
  const SampleSet places(dims);
  for (std::size_t i = 0; i < 3; ++i) counts_[i] = (dims[i] + edge - 1) / edge;
  for_each_point({{}, counts_}, [&](const Index3& brick) {
    const IndexBox box =
        intersection({brick * edge, brick * edge + Index3{{edge, edge, edge}}}, {{}, dims});
    std::vector<std::byte> raw;
    for_each_point(box, [&](const Index3& p) {
      const std::byte* from = volume.samples.data() + places.index_of(p) * size;
      raw.insert(raw.end(), from, from + size);
    });
    sizes_.push_back(std::min(raw.size(), store::zstd_compress(raw).size()));
  });
}

Touched PlainBricks::touched(const SampleSet& samples) const {
  std::vector<bool> is_touched(sizes_.size());
  for_each_point({{}, samples.dims()}, [&](const Index3& p) {
    if (!samples.is_in()[samples.index_of(p)]) return;
    const Index3 brick{{p[0] / edge_, p[1] / edge_, p[2] / edge_}};
    is_touched[static_cast<std::size_t>(brick[0] +
                                        counts_[0] * (brick[1] + counts_[1] * brick[2]))] = true;
  });
  Touched result;
  for (std::size_t i = 0; i < sizes_.size(); ++i)
    if (is_touched[i]) result = {result.blocks + 1, result.bytes + sizes_[i]};
  return result;
}

std::uint64_t PlainBricks::n_bytes() const {
  std::uint64_t n = 0;
  for (const std::uint64_t size : sizes_) n += size;
  return n;
}

Touched touched_pages(const SampleSet& samples, std::size_t sample_size) {
  const std::size_t n_bytes = samples.is_in().size() * sample_size;
  const std::uint64_t n = count_places(samples, n_bytes / kPageBytes + 1,
                                       [&](std::size_t i) { return i * sample_size / kPageBytes; });
  return {n, std::min<std::uint64_t>(n * kPageBytes, n_bytes)};
}

Touched touched_slabs(const SampleSet& samples, std::size_t sample_size) {
  const auto n_slab =
      static_cast<std::size_t>(samples.dims()[0]) * static_cast<std::size_t>(samples.dims()[1]);
  const std::uint64_t n = count_places(samples, static_cast<std::size_t>(samples.dims()[2]),
                                       [&](std::size_t i) { return i / n_slab; });
  return {n, n * n_slab * sample_size};
}

}  // namespace lode::bench
