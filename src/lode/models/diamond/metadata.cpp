#include <limits>

#include "lode/core/label.h"
#include "lode/models/diamond/block_layout.h"
#include "lode/models/diamond/persist.h"
#include "lode/store/bytes.h"

namespace lode::diamond {
namespace {

Result<void> read_grid(store::ByteReader& in, const std::string& path, RegularGrid& grid) {
  for (std::int32_t& n : grid.dims.v) {
    LODE_TRY(n, in.read<std::int32_t>());
    if (n < 1 || n > kMaxSamplesPerAxis)
      return fail("{}: metadata: expected 1 to {} samples along an axis, got {}", path,
                  kMaxSamplesPerAxis, n);
  }
  for (double& x : grid.spacing.v) {
    LODE_TRY(x, in.read<double>());
    if (!(x > 0) || !std::isfinite(x))
      return fail("{}: metadata: expected a positive spacing, got {}", path, x);
  }
  for (double& x : grid.origin.v) {
    LODE_TRY(x, in.read<double>());
    if (!std::isfinite(x)) return fail("{}: metadata: expected a finite origin", path);
  }
  for (Vec3d& row : grid.direction.rows)
    for (double& x : row.v) {
      LODE_TRY(x, in.read<double>());
    }
  // The readers of foreign files ask the same.
  if (!(std::abs(determinant(grid.direction)) >= 1e-6))
    return fail("{}: metadata: expected independent directions of the axes", path);
  const Box3d bounds = grid.world_bounds();
  for (std::size_t i = 0; i < 3; ++i)
    if (!std::isfinite(bounds.lower[i]) || !std::isfinite(bounds.upper[i]))
      return fail("{}: metadata: expected a grid whose places are finite", path);
  return {};
}

Result<VolumeInfo> read_info(store::ByteReader& in, const std::string& path) {
  VolumeInfo info;
  LODE_CHECK(read_grid(in, path, info.grid));
  LODE_TRY(const auto frame, in.read<std::uint8_t>());
  LODE_TRY(const auto type, in.read<std::uint8_t>());
  LODE_TRY(const auto has_nodata, in.read<std::uint8_t>());
  LODE_TRY(const auto nodata, in.read<double>());
  LODE_TRY(info.field_name, in.read_string());
  info.type = static_cast<ScalarType>(type);
  if (!is_valid(info.type) || frame > static_cast<std::uint8_t>(Frame::lps))
    return fail("{}: metadata: expected a sample type 1..10 and a frame 0..2, got {} and {}", path,
                type, frame);
  info.grid.frame = static_cast<Frame>(frame);
  if (has_nodata != 0) info.nodata = nodata;
  return info;
}

/// What a rebuilt file required is lost with its header.
bool has_units(const store::Reader& reader, const store::ByteReader& in) {
  return reader.is_rebuilt() ? in.n_left() > 0 : (reader.features() & store::kFeatureUnits) != 0;
}

Result<Units> read_units(store::ByteReader& in, const std::string& path) {
  Units units;
  for (std::string* const unit : {&units.length, &units.value}) {
    LODE_TRY(*unit, in.read_string());
    if (const auto fault = label_fault(*unit))
      return fail("{}: metadata: expected a unit, got a text with {}", path, *fault);
  }
  return units;
}

Result<FieldStats> read_stats(store::ByteReader& in, const std::string& path,
                              std::uint64_t n_samples) {
  FieldStats stats;
  LODE_TRY(stats.min, in.read<double>());
  LODE_TRY(stats.max, in.read<double>());
  if (!std::isfinite(stats.min) || !std::isfinite(stats.max) || stats.min > stats.max)
    return fail("{}: metadata: expected a finite range of the samples, got {} to {}", path,
                stats.min, stats.max);
  if (auto checked = check_magnitude(stats); !checked)
    return fail("{}: metadata: {}", path, checked.error().message);
  LODE_TRY(stats.n_holes, in.read<std::uint64_t>());
  LODE_TRY(stats.n_removed_cells, in.read<std::uint64_t>());
  if (stats.n_holes > n_samples || stats.n_removed_cells > n_samples)
    return fail("{}: metadata: expected up to {} holes and removed cells, got {} and {}", path,
                n_samples, stats.n_holes, stats.n_removed_cells);
  return stats;
}

Result<double> read_error(store::ByteReader& in, const std::string& path) {
  LODE_TRY(const double error, in.read<double>());
  if (!(error >= 0)) return fail("{}: metadata: expected an error >= 0, got {}", path, error);
  return error;
}

/// Refuses metadata that promises other samples than the directory holds, before memory is asked.
template <int D>
Result<void> check_size(const store::Reader& reader, const VolumeInfo& info) {
  const std::uint64_t expected =
      count_stored_samples<D>(shape_of<D>(info.grid.dims)) * size_of(storage_type(info.type));
  std::uint64_t present = 0;
  for (const store::BlockEntry& block : reader.blocks())
    if (block.key.kind == static_cast<std::uint32_t>(Kind::samples)) present += block.raw_size;
  // The blocks that were cut off are not there to be counted.
  const bool is_possible = reader.is_rebuilt()
                               ? expected / store::kMaxZstdRatio <= reader.file_size()
                               : expected == present;
  if (is_possible) return {};
  return fail("{}: expected {} bytes of samples for {} x {} x {}, {} {}", reader.path(), expected,
              info.grid.dims[0], info.grid.dims[1], info.grid.dims[2],
              reader.is_rebuilt() ? "too many for what is left of it, bytes:" : "its blocks hold",
              reader.is_rebuilt() ? reader.file_size() : present);
}

}  // namespace

std::vector<std::byte> encode_metadata(const Metadata& metadata) {
  const VolumeInfo& info = metadata.info;
  const Summary& summary = metadata.summary;
  store::ByteWriter out;
  for (const std::int32_t n : info.grid.dims.v) out.write(n);
  for (const double x : info.grid.spacing.v) out.write(x);
  for (const double x : info.grid.origin.v) out.write(x);
  for (const Vec3d& row : info.grid.direction.rows)
    for (const double x : row.v) out.write(x);
  out.write(static_cast<std::uint8_t>(info.grid.frame));
  out.write(static_cast<std::uint8_t>(info.type));
  out.write(static_cast<std::uint8_t>(info.nodata.has_value() ? 1 : 0));
  out.write(info.nodata.value_or(0));
  out.write_string(info.field_name);
  out.write(summary.stats.min);
  out.write(summary.stats.max);
  out.write(summary.stats.n_holes);
  out.write(summary.stats.n_removed_cells);
  out.write(summary.base_error);
  out.write_all(std::span(summary.max_errors));
  if (!info.units.is_empty()) {
    out.write_string(info.units.length);
    out.write_string(info.units.value);
  }
  return std::move(out).take();
}

std::vector<std::byte> encode_early_metadata(const VolumeInfo& info, const FieldStats& stats) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  const auto n_levels = static_cast<std::size_t>(Shape<3>::of(info.grid.dims).n_levels);
  return encode_metadata({info, {stats, kUnknown, std::vector<double>(n_levels, kUnknown)}});
}

Result<Metadata> read_metadata(const store::Reader& reader) {
  const std::string& path = reader.path();
  store::ByteReader in(reader.metadata(), path + ": metadata");
  Metadata metadata;
  LODE_TRY(metadata.info, read_info(in, path));
  const RegularGrid& grid = metadata.info.grid;
  const Index3& dims = grid.dims;
  if (reader.model() == model_name<2>() && std::min({dims[0], dims[1], dims[2]}) > 1)
    return fail("{}: metadata: expected an axis with one sample for {}, got {} x {} x {}", path,
                reader.model(), dims[0], dims[1], dims[2]);
  Summary& summary = metadata.summary;
  LODE_TRY(summary.stats, read_stats(in, path, static_cast<std::uint64_t>(grid.n_samples())));
  LODE_TRY(summary.base_error, read_error(in, path));
  // Axes with one sample, which a diamond2d leaves aside, ask for no level.
  const int n_levels = Shape<3>::of(dims).n_levels;
  for (int level = 0; level < n_levels; ++level) {
    LODE_TRY(const double error, read_error(in, path));
    summary.max_errors.push_back(error);
  }
  if (has_units(reader, in)) {
    LODE_TRY(metadata.info.units, read_units(in, path));
  }
  LODE_CHECK(in.expect_end());
  if (reader.model() == model_name<2>())
    LODE_CHECK(check_size<2>(reader, metadata.info));
  else
    LODE_CHECK(check_size<3>(reader, metadata.info));
  return metadata;
}

bool has_current_errors(const store::Reader& reader, const Metadata& metadata) {
  return metadata.summary.stats.n_holes == 0 ||
         (reader.features() & store::kFeatureRemovedCells) != 0;
}

Result<void> check_current(const store::Reader& reader, const Metadata& metadata) {
  if (has_current_errors(reader, metadata)) return {};
  return fail(
      "{}: a field with holes made by an older version of lode: build it again (or `lode extract "
      "--salvage`)",
      reader.path());
}

}  // namespace lode::diamond
