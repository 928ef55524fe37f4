#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/result.h"
#include "lode/store/bytes.h"
#include "lode/store/reader.h"

namespace lode::terrain_file {

/// What a model remembers of the raster or points that it was built of.
struct Source {
  HeightFrame frame;
  /// Of scattered points, or of a raster with lines: nodes of the lattice need have no heights, and
  /// there are up to kMostPointNodes columns and rows. Nothing that write() writes.
  bool is_of_points = false;
  HeightRange range;            ///< Of all samples.
  std::string sample_type;      ///< As the raster's reader names it.
  bool has_place = true;        ///< Else the frame is that of columns and rows.
  std::uint64_t n_samples = 0;  ///< In cells with four heights.
  std::uint64_t n_missing = 0;
  std::uint64_t n_left_out = 0;
};

/// Which of these models a file is of; fails, naming the file, where it is of none.
[[nodiscard]] Result<std::size_t> find_model(const store::Reader& reader,
                                             std::span<const std::string_view> models);

inline constexpr std::uint32_t kMaxLevels = 4096;

/// See HeightPoints.
inline constexpr std::int32_t kMostPointNodes = 1 << 30;

/// As docs/format.md has it. Reading fails on what it does not allow, naming the path; the source
/// says by then whether it is of points.
void write(store::ByteWriter& out, const Source& source);
[[nodiscard]] Result<void> read(store::ByteReader& in, const std::string& path, Source& source);

/// Tolerances, each finer than the one before, up to kMaxLevels.
void write_levels(store::ByteWriter& out, const std::vector<double>& levels);
[[nodiscard]] Result<std::vector<double>> read_levels(store::ByteReader& in,
                                                      const std::string& path);

}  // namespace lode::terrain_file
