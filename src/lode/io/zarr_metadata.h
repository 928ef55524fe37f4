#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "lode/io/zarr_array.h"

namespace lode::io {

/// The array that a .zarray says; `path` is that file. What is read is not yet checked against
/// the rest (see read_zarr_array).
[[nodiscard]] Result<ZarrArray> parse_zarr_v2(const std::string& path,
                                              const nlohmann::json& metadata);

/// A sample of `type`: a number, "NaN", "Infinity", "-Infinity", the bits of a floating-point one
/// as "0x7fc00000", or null for 0. Fails when it is none or the type cannot hold it.
[[nodiscard]] Result<ZarrFill> parse_zarr_fill(const std::string& path, ScalarType type,
                                               const nlohmann::json* value);

}  // namespace lode::io
