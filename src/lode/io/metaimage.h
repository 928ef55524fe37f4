#pragma once

#include <string>

#include "lode/core/result.h"
#include "lode/io/image.h"
#include "lode/io/sample_storage.h"

namespace lode::io {

/// MetaImage: .mha with its samples, .mhd with a data file; plain, zlib compressed or as text.
/// The frame is named only where AnatomicalOrientation and the matrix together tell it.
/// https://itk.org/Wiki/ITK/MetaIO/Documentation
[[nodiscard]] Result<Image> read_metaimage(const std::string& path, const SampleStorage& storage);

}  // namespace lode::io
