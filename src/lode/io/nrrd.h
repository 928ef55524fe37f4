#pragma once

#include <string>

#include "lode/core/result.h"
#include "lode/io/image.h"
#include "lode/io/sample_storage.h"

namespace lode::io {

/// NRRD 1 to 5, attached (.nrrd) or detached (.nhdr with one data file); encodings raw, gzip,
/// text and hex.
/// http://teem.sourceforge.net/nrrd/format.html
[[nodiscard]] Result<Image> read_nrrd(const std::string& path, const SampleStorage& storage);

}  // namespace lode::io
