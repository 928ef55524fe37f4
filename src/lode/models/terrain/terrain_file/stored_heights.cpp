#include "lode/models/terrain/terrain_file/stored_heights.h"

#include <algorithm>
#include <cmath>

namespace lode::terrain_file {
namespace {

template <typename T>
Result<void> append_as(const ColumnKey& column, std::span<const double> heights,
                       store::Writer& writer) {
  return append_column<T>(
      column, heights.size(), [&](std::uint64_t i) { return static_cast<T>(heights[i]); }, writer);
}

template <typename T>
Result<std::vector<double>> read_as(const store::Reader& reader, const ColumnKey& column,
                                    std::uint64_t n) {
  LODE_TRY(const std::vector<T> heights, read_column<T>(reader, column, n));
  return std::vector<double>(heights.begin(), heights.end());
}

Result<std::vector<double>> read_any(const store::Reader& reader, const ColumnKey& column,
                                     StoredHeight type, std::uint64_t n) {
  switch (type) {
    case StoredHeight::int16: return read_as<std::int16_t>(reader, column, n);
    case StoredHeight::float32: return read_as<float>(reader, column, n);
    case StoredHeight::float64: break;
  }
  return read_as<double>(reader, column, n);
}

}  // namespace

StoredHeight narrowest(std::span<const double> heights) {
  const auto all = [&](const auto& holds) { return std::ranges::all_of(heights, holds); };
  if (all([](double z) {
        return std::abs(z) <= 32767 && z == std::floor(z) && !(z == 0 && std::signbit(z));
      }))
    return StoredHeight::int16;
  if (all([](double z) { return static_cast<double>(static_cast<float>(z)) == z; }))
    return StoredHeight::float32;
  return StoredHeight::float64;
}

Result<StoredHeight> read_stored_height(store::ByteReader& in, const std::string& path) {
  LODE_TRY(const auto type, in.read<std::uint8_t>());
  if (type < 1 || type > 3)
    return fail("{}: metadata: expected a type of heights from 1 to 3, got {}", path, type);
  return static_cast<StoredHeight>(type);
}

Result<void> append_heights(const ColumnKey& column, StoredHeight type,
                            std::span<const double> heights, store::Writer& writer) {
  switch (type) {
    case StoredHeight::int16: return append_as<std::int16_t>(column, heights, writer);
    case StoredHeight::float32: return append_as<float>(column, heights, writer);
    case StoredHeight::float64: break;
  }
  return append_as<double>(column, heights, writer);
}

Result<std::vector<double>> read_heights(const store::Reader& reader, const ColumnKey& column,
                                         StoredHeight type, std::uint64_t n,
                                         const HeightRange& range) {
  LODE_TRY(std::vector<double> heights, read_any(reader, column, type, n));
  for (const double z : heights)
    if (!(z >= range.lower && z <= range.upper))
      return fail("{}: expected heights from {} to {}, got {}", reader.path(), range.lower,
                  range.upper, z);
  return heights;
}

}  // namespace lode::terrain_file
