#pragma once

#include <cstring>
#include <vector>

#include "lode/models/diamond/block_layout.h"
#include "lode/store/reader.h"

namespace lode::diamond {

/// Where in the file a region's block is. Fails where the file has none, or one of another size
/// than its points take, of which there are some.
template <int D>
[[nodiscard]] Result<std::size_t> find_region(const store::Reader& reader, const Region<D>& region,
                                              Kind kind, std::size_t element_size) {
  const std::size_t n_bytes = count_points(region) * element_size;
  const store::BlockKey key = key_of(kind, region);
  const auto at = reader.find(key);
  if (!at) return fail("{}: expected {}, but the file has none", reader.path(), describe(key));
  const std::uint64_t n_found = reader.blocks()[*at].raw_size;
  if (n_found != n_bytes)
    return fail("{}: {}: expected {} bytes, got {}", reader.path(), describe(key), n_bytes,
                n_found);
  return *at;
}

/// The bytes of a region's block, as many as its points take; none where it has no points. Fails
/// where the file has no such block, or one of another size.
template <int D>
[[nodiscard]] Result<std::vector<std::byte>> read_region(const store::Reader& reader,
                                                         const Region<D>& region, Kind kind,
                                                         std::size_t element_size) {
  if (count_points(region) == 0) return std::vector<std::byte>();
  LODE_TRY(const std::size_t at, find_region<D>(reader, region, kind, element_size));
  return reader.read_block(at);
}

/// Calls put(place in arrays on the level's grid, of so many points, value) for the points of a
/// region's block.
template <typename T, int D, typename Put>
void for_each_value(const Region<D>& r, const Index<D>& dims, const std::byte* from,
                    const Put& put) {
  for_each_row<D>(r, [&](const Index<D>& q, std::int32_t n, std::int32_t stride) {
    const std::size_t first = linear_index<D>(dims, q);
    for (std::size_t i = 0; i < as_size(n); ++i, from += sizeof(T)) {
      T value;
      std::memcpy(&value, from, sizeof(T));
      put(first + i * as_size(stride), value);
    }
  });
}

}  // namespace lode::diamond
