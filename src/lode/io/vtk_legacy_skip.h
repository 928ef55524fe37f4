#pragma once

#include "lode/core/result.h"
#include "lode/io/vtk_legacy_arrays.h"

namespace lode::io {

/// Notes where the values of `array` start (the cursor's position) and skips them. Strings are a
/// line each in ASCII files, else their length and characters; bits are words, else eight a byte;
/// variants are lines in both.
[[nodiscard]] Result<void> skip_array(LegacyFile& file, LegacyArray& array);

/// Skips what follows METADATA after an array, up to a blank line: its components' names, of which
/// any may be blank, and as many keys of its information as it says, whose texts may be blank.
/// Fails where these do not come.
[[nodiscard]] Result<void> skip_metadata(LegacyFile& file);

}  // namespace lode::io
