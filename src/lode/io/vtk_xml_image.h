#pragma once

#include <string>

#include "lode/core/result.h"
#include "lode/io/image.h"
#include "lode/io/sample_storage.h"

namespace lode::io {

/// VTK XML ImageData (.vti) and RectilinearGrid with evenly spaced axes (.vtr), one piece, point
/// data; zlib compressed or not. https://docs.vtk.org/en/latest/vtk_file_formats
[[nodiscard]] Result<Image> read_vtk_xml_image(const std::string& path,
                                               const SampleStorage& storage);

}  // namespace lode::io
