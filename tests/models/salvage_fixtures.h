#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "lode/io/volume_reader.h"
#include "lode/models/diamond/salvage.h"
#include "tests/models/stored_fixtures.h"

namespace lode::test {

/// Waves of a few samples to some tens: errors are small where samples are near, and never zero.
inline Volume wavy_samples(const Index3& dims, ScalarType type) {
  RegularGrid grid;
  grid.dims = dims;
  grid.spacing = {{1, 0.5, 2}};
  grid.origin = {{-3, 4, 10}};
  Volume volume = oracles::empty_volume(grid, type);
  visit_scalar_type(type, [&]<typename T>() {
    auto samples = oracles::typed_samples<T>(volume);
    std::size_t at = 0;
    for (int z = 0; z < dims[2]; ++z)
      for (int y = 0; y < dims[1]; ++y)
        for (int x = 0; x < dims[0]; ++x)
          samples[at++] = oracles::to_sample<T>(60 + 30 * std::sin(x * 0.11) * std::cos(y * 0.17) +
                                                25 * std::sin(z * 0.13 + x * 0.05));
  });
  return volume;
}

/// A part of the bundled scan, with what a scanner's noise, air and edges are like.
inline Volume part_of_scan() {
  const auto source = io::open_volume(LODE_SAMPLES_DIR "/tooth.nrrd", {});
  EXPECT_TRUE(source) << (source ? "" : source.error().message);
  VolumeInfo info = (*source)->info();
  const IndexBox box{{{15, 20, 60}}, {{83, 44, 77}}};
  info.grid.dims = box.dims();
  Volume volume = oracles::empty_volume(info.grid, info.type);
  volume.info = info;
  EXPECT_TRUE((*source)->read(box, volume.samples));
  return volume;
}

/// Makes so many of a hundred samples holes.
inline void poke_holes(Volume& volume, std::uint64_t percent) {
  oracles::Random random(41);
  visit_scalar_type(volume.info.type, [&]<typename T>() {
    for (T& v : oracles::typed_samples<T>(volume)) {
      if (random.below(100) >= percent) continue;
      v = std::is_floating_point_v<T> ? std::numeric_limits<T>::quiet_NaN() : T(5);
    }
    if (!std::is_floating_point_v<T>) volume.info.nodata = 5;
  });
}

/// A .lode file in memory, to be damaged: blocks by their numbers in the directory, indexes left
/// aside.
struct StoredFile {
  explicit StoredFile(const std::string& path)
      : bytes(store::load_file(path)), reader(store::Reader::open(path).value()) {
    for (const store::BlockEntry& block : reader.blocks())
      (store::is_index(block.key) ? indexes : blocks).push_back(block);
  }

  /// Writes it to `path` with one bit of each of these blocks changed.
  void write_damaged(const std::string& path, const std::set<std::size_t>& numbers) const {
    Bytes damaged = bytes;
    for (const std::size_t i : numbers) {
      const store::BlockEntry& block = blocks[i];
      damaged[block.offset + block.stored_size / 2] ^= std::byte{0x10};
    }
    store::save_file(path, damaged);
  }
  [[nodiscard]] std::size_t n_blocks() const { return blocks.size(); }
  [[nodiscard]] bool is_samples(std::size_t i) const { return blocks[i].key.kind == 1; }
  [[nodiscard]] std::optional<std::size_t> find(const store::BlockKey& key) const {
    const auto at = std::ranges::find(blocks, key, &store::BlockEntry::key);
    if (at == blocks.end()) return std::nullopt;
    return static_cast<std::size_t>(at - blocks.begin());
  }

  Bytes bytes;
  store::Reader reader;
  std::vector<store::BlockEntry> blocks;
  std::vector<store::BlockEntry> indexes;
};

/// Where a sample is stored, as docs/format.md says it, sharing nothing with the library: the level
/// from the powers of two in its coordinates, the position from the sizes of the level's grid.
inline store::BlockKey block_of_sample(const Index3& dims, const Index3& p, bool is_flat) {
  int n_levels = 1;
  while ((1 << n_levels) < std::max({dims[0], dims[1], dims[2]}) - 1) ++n_levels;
  int level = n_levels - 1;
  for (const std::int32_t x : p.v)
    for (int k = 0; k < level; ++k)
      if (x % (2 << k) != 0) level = k;
  std::vector<int> axes;
  for (int a = 0; a < 3; ++a)
    if (!is_flat || dims[static_cast<std::size_t>(a)] > 1) axes.push_back(a);
  for (int a = 0; is_flat && axes.size() < 2; ++a)
    if (dims[static_cast<std::size_t>(a)] == 1) axes.push_back(a);
  std::sort(axes.begin(), axes.end());
  store::BlockKey key{1, static_cast<std::uint32_t>(level), {}};
  const int edge = is_flat ? 512 : 64;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto axis = static_cast<std::size_t>(axes[i]);
    const int step = 2 << level;
    const int n_grid = level == 0 ? dims[axis] : 2 * ((dims[axis] - 1 + step - 1) / step) + 1;
    const int n_blocks = std::max(1, (n_grid - 1 + edge - 1) / edge);
    key.position[i] = std::min((p[axis] >> level) / edge, n_blocks - 1);
  }
  return key;
}

/// A volume's sample as a double, NaN for a hole.
inline double sample_or_nan(const Volume& volume, std::size_t at) {
  return visit_scalar_type(volume.info.type, [&]<typename T>() {
    const auto value = static_cast<double>(volume.as<T>()[at]);
    const bool is_hole =
        !std::isfinite(value) || (volume.info.nodata && value == *volume.info.nodata);
    return is_hole ? std::nan("") : value;
  });
}

template <int D>
Result<diamond::Salvaged<D>> salvage(const std::string& path, int n_threads = 2) {
  LODE_TRY(const auto reader, store::Reader::open(path, {.length = store::Length::any}));
  Progress progress;
  return diamond::salvage<D>(reader, {n_threads}, progress);
}

}  // namespace lode::test
