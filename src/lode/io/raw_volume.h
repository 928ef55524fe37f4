#pragma once

#include <string>

#include "lode/core/result.h"
#include "lode/io/image.h"
#include "lode/io/sample_storage.h"
#include "lode/io/volume_reader.h"

namespace lode::io {

/// Bare samples, gzip compressed where the name ends in .gz. The size must fit exactly.
[[nodiscard]] Result<Image> read_raw(const std::string& path, const RawLayout& layout,
                                     const SampleStorage& storage);

}  // namespace lode::io
