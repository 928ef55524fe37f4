#pragma once

#include "lode/api/salvage.h"
#include "lode/core/regular_grid.h"
#include "lode/models/diamond/salvage.h"
#include "lode/store/reader.h"

namespace lode {

/// A file's reader, whatever its length. Where header or directory are damaged the failure says
/// that nothing can be salvaged.
[[nodiscard]] Result<store::Reader> open_damaged(const std::string& path);

/// The same in world units and by levels.
[[nodiscard]] SalvageReport to_report(const diamond::SalvageReport& found, const RegularGrid& grid);

}  // namespace lode
