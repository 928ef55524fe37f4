#pragma once

#include <optional>
#include <string>

#include "lode/core/result.h"

namespace lode::io {

/// What to do with DICOM, of which each slice is a file and which is not read: an error if `path`
/// is such a file, or a directory whose first files are.
[[nodiscard]] std::optional<Error> refuse_dicom(const std::string& path);

}  // namespace lode::io
