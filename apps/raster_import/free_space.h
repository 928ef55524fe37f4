#pragma once

#include <cstdint>
#include <string>

namespace lode::raster_import {

/// Throws std::runtime_error where a file, or the directory that it is to be in, has no room for so
/// much, and a little beside.
void check_space(const std::string& output, std::uint64_t n_bytes);

}  // namespace lode::raster_import
