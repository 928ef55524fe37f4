#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "lode/io/zarr_array.h"

namespace lode::io {

/// The array that a .zarray says; `path` is that file. What is read is not yet checked against
/// the rest (see read_zarr_array).
[[nodiscard]] Result<ZarrArray> parse_zarr_v2(const std::string& path,
                                              const nlohmann::json& metadata);

/// The array that a zarr.json says, in the same way. Fails, naming it, on any extension that must
/// be understood.
[[nodiscard]] Result<ZarrArray> parse_zarr_v3(const std::string& path,
                                              const nlohmann::json& metadata);

/// A name and what stands beside it; version 3 has them for types, grids, keys and codecs.
struct ZarrExtension {
  std::string name;
  const nlohmann::json* configuration = nullptr;  ///< An object, empty where there is none.
};
/// `member` (null: missing) is what the metadata have for `what`, an object or a bare name.
[[nodiscard]] Result<ZarrExtension> parse_zarr_extension(const std::string& path,
                                                         const nlohmann::json* member,
                                                         std::string_view what);

/// What the codecs of a list work on.
struct ZarrCodedArray {
  std::size_t rank = 0;
  ScalarType type = ScalarType::uint8;
};
/// The codecs of version 3: transpose, then bytes or sharding_indexed, then gzip, zstd, blosc and
/// crc32c. Fails, naming it, on any other, and on more than one compressor.
[[nodiscard]] Result<ZarrCodecs> parse_zarr_codecs(const std::string& path,
                                                   const nlohmann::json* list,
                                                   const ZarrCodedArray& array);

/// A sample of `type`: a number, "NaN", "Infinity", "-Infinity", the bits of a floating-point one
/// as "0x7fc00000", or null for 0. Fails when it is none or the type cannot hold it.
[[nodiscard]] Result<ZarrFill> parse_zarr_fill(const std::string& path, ScalarType type,
                                               const nlohmann::json* value);

}  // namespace lode::io
