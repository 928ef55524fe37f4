#pragma once

#include <array>
#include <string>
#include <type_traits>
#include <vector>

#include "tests/io/volume_test_files.h"

namespace lode::io::test {

/// The part of tests/io/zarr/fixtures.tar.gz below `prefix` ("v2/group_two"), in a directory that
/// is removed at the end. Other libraries wrote it: see the README.md there.
class ZarrFixture {
 public:
  explicit ZarrFixture(const std::string& prefix);

  /// The unpacked directory itself, or something in it.
  [[nodiscard]] std::string path() const { return dir_.path(prefix_); }
  [[nodiscard]] std::string path(const std::string& name) const { return path() + '/' + name; }
  /// Writes, replaces or reads a file in it.
  void write(const std::string& name, const std::string& bytes) const;
  [[nodiscard]] std::string read(const std::string& name) const;

 private:
  TempDir dir_;
  std::string prefix_;
};

/// The sample that the generators' formula gives at number k.
template <typename T>
T zarr_sample(std::int64_t k) {
  const std::int64_t step = k % 200;
  if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(static_cast<double>(step - 100) * 0.75);
  } else {
    const std::uint64_t ones = 0x0101010101010101ULL >> (64 - 8 * sizeof(T));
    const std::int64_t signed_step = std::is_signed_v<T> ? step - 100 : step;
    return static_cast<T>(static_cast<std::uint64_t>(signed_step) * ones);
  }
}

/// What the generators call SMALL and LARGE.
inline constexpr Index3 kSmallZarr{{10, 7, 3}};
inline constexpr Index3 kLargeZarr{{30, 24, 8}};

/// Where a three-dimensional part of an array with more axes lies.
struct ZarrPlace {
  std::int64_t time = 0;
  std::int64_t channel = 0;
};

/// The samples of the generators' arrays, x fastest.
template <typename T>
std::vector<T> zarr_samples(const Index3& dims, ZarrPlace place = {}) {
  std::vector<T> samples;
  for (std::int64_t z = 0; z < dims[2]; ++z)
    for (std::int64_t y = 0; y < dims[1]; ++y)
      for (std::int64_t x = 0; x < dims[0]; ++x)
        samples.push_back(
            zarr_sample<T>(5003 * place.time + 1009 * place.channel + 101 * z + 13 * y + x));
  return samples;
}

/// Samples of kSmallZarr where chunk z y x = 0 0 1 holds `fill`: x from 5, y to 3, z to 1.
template <typename T>
[[nodiscard]] std::vector<T> with_missing_chunk(T fill) {
  std::vector<T> samples = zarr_samples<T>(kSmallZarr);
  for (std::size_t z = 0; z < 2; ++z)
    for (std::size_t y = 0; y < 4; ++y)
      for (std::size_t x = 5; x < 10; ++x) samples[(z * 7 + y) * 10 + x] = fill;
  return samples;
}

}  // namespace lode::io::test
