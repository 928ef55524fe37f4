#include "lode/models/terrain/terrain_file/source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "lode/core/expects.h"
#include "lode/delaunay/grid_domain.h"
#include "lode/delaunay/lattice.h"

namespace lode::terrain_file {
namespace {

Result<void> read_frame(store::ByteReader& in, const std::string& path, Source& source) {
  HeightFrame& frame = source.frame;
  LODE_TRY(frame.n_columns, in.read<std::int32_t>());
  LODE_TRY(frame.n_rows, in.read<std::int32_t>());
  const bool fits = source.is_of_points
                        ? std::max(frame.n_columns, frame.n_rows) <= kMostPointNodes
                        : delaunay::LatticePacking::fits(frame.n_columns, frame.n_rows);
  if (frame.n_columns < 2 || frame.n_rows < 2 || !fits)
    return fail("{}: metadata: expected columns and rows whose numbers fit 32 bits, got {} x {}",
                path, frame.n_columns, frame.n_rows);
  for (double& x : frame.to_world) {
    LODE_TRY(x, in.read<double>());
    if (!std::isfinite(x))
      return fail("{}: metadata: expected finite numbers that place the lattice, got {}", path, x);
  }
  const auto& g = frame.to_world;
  if (const double determinant = g[1] * g[5] - g[2] * g[4];
      determinant == 0 || !std::isfinite(determinant))
    return fail("{}: metadata: expected columns and rows that span a plane", path);
  LODE_TRY(frame.crs, in.read_string());
  LODE_TRY(frame.vertical_unit, in.read_string());
  return {};
}

}  // namespace

Result<std::size_t> find_model(const store::Reader& reader,
                               std::span<const std::string_view> models) {
  const auto found = std::ranges::find(models, reader.model());
  if (found != models.end()) return static_cast<std::size_t>(found - models.begin());
  return fail("{}: expected one of the models {}, got {}", reader.path(), fmt::join(models, ", "),
              reader.model());
}

void write(store::ByteWriter& out, const Source& source) {
  out.write(source.frame.n_columns);
  out.write(source.frame.n_rows);
  out.write_all(std::span<const double>(source.frame.to_world));
  out.write_string(source.frame.crs);
  out.write_string(source.frame.vertical_unit);
  out.write_string(source.sample_type);
  out.write(static_cast<std::uint8_t>(source.has_place));
  out.write(source.range.lower);
  out.write(source.range.upper);
  out.write(source.n_samples);
  out.write(source.n_missing);
  out.write(source.n_left_out);
}

Result<void> read(store::ByteReader& in, const std::string& path, Source& source) {
  LODE_CHECK(read_frame(in, path, source));
  LODE_TRY(source.sample_type, in.read_string());
  LODE_TRY(const auto has_place, in.read<std::uint8_t>());
  source.has_place = has_place != 0;
  LODE_TRY(source.range.lower, in.read<double>());
  LODE_TRY(source.range.upper, in.read<double>());
  if (!(source.range.lower <= source.range.upper) ||
      !std::isfinite(source.range.upper - source.range.lower))
    return fail("{}: metadata: expected a finite range of heights, got {} to {}", path,
                source.range.lower, source.range.upper);
  // As when models are made: what is computed of these stays finite.
  if (const auto checked = delaunay::check_heights(source.range); !checked)
    return fail("{}: metadata: {}", path, checked.error().message);
  LODE_TRY(source.n_samples, in.read<std::uint64_t>());
  LODE_TRY(source.n_missing, in.read<std::uint64_t>());
  LODE_TRY(source.n_left_out, in.read<std::uint64_t>());
  return {};
}

void write_levels(store::ByteWriter& out, const std::vector<double>& levels) {
  LODE_EXPECTS(levels.size() <= kMaxLevels);
  out.write(static_cast<std::uint32_t>(levels.size()));
  out.write_all(std::span<const double>(levels));
}

Result<std::vector<double>> read_levels(store::ByteReader& in, const std::string& path) {
  LODE_TRY(const auto n, in.read<std::uint32_t>());
  if (n > kMaxLevels)
    return fail("{}: metadata: expected up to {} levels, got {}", path, kMaxLevels, n);
  LODE_TRY(std::vector<double> levels, in.read_all<double>(n));
  for (std::size_t i = 0; i < levels.size(); ++i)
    if (!(levels[i] >= 0) || !std::isfinite(levels[i]) || (i > 0 && levels[i] >= levels[i - 1]))
      return fail("{}: metadata: expected levels that get finer, got {}", path, levels[i]);
  return levels;
}

}  // namespace lode::terrain_file
