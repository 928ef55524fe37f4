#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "lode/core/result.h"
#include "lode/core/vec.h"

namespace lode::io {

/// An extent as VTK XML files write it: the first and last point along each axis.
struct VtkExtent {
  std::array<std::int64_t, 3> first{};
  Index3 dims;
};

[[nodiscard]] Result<VtkExtent> parse_vtk_extent(const std::string& path, const char* text);

}  // namespace lode::io
