#pragma once

// A raster in the file of a model that has all of its samples.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/core/lattice_point.h"
#include "lode/core/result.h"
#include "lode/models/terrain/terrain_file/columns.h"
#include "lode/models/terrain/terrain_file/source.h"
#include "lode/store/reader.h"
#include "lode/store/writer.h"

namespace lode::terrain_file {

/// The columns that stored rasters are made of; docs/format.md says what they hold. A model's own
/// have other numbers.
enum class RasterColumn : std::uint32_t {
  height = 1,    ///< By sample, row by row, in the type that the head says; 0 where none is.
  is_valid = 2,  ///< uint8 by sample; only where heights are missing.
  kept = 4,      ///< uint32 twice by kept sample: column and row.
};

struct StoredRaster {
  Source source;
  std::vector<double> levels;  ///< Each finer than the one before.
  HeightGrid grid;
  std::vector<LatticePoint> kept;  ///< In rows; whether they are in the domain is not known yet.
};

/// The metadata of a model of that layout.
[[nodiscard]] std::vector<std::byte> encode_raster_head(std::uint32_t layout, const Source& source,
                                                        const std::vector<double>& levels,
                                                        const HeightGrid& grid, std::size_t n_kept);
[[nodiscard]] Result<void> append_raster(const HeightGrid& grid,
                                         const std::vector<LatticePoint>& kept,
                                         store::Writer& writer);

/// Fails, naming the file, on what docs/format.md does not allow.
[[nodiscard]] Result<StoredRaster> read_raster(const store::Reader& reader, std::uint32_t layout);
/// Fails where one of the kept samples is not in the domain.
[[nodiscard]] Result<void> check_kept(const std::string& path,
                                      const std::vector<LatticePoint>& kept,
                                      const std::function<bool(LatticePoint)>& has_node);

/// That what another read of a file says holds, with its name.
template <typename T>
[[nodiscard]] Result<T> naming(const std::string& path, Result<T> result) {
  if (result) return result;
  return fail("{}: {}", path, result.error().message);
}

}  // namespace lode::terrain_file
