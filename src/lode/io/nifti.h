#pragma once

#include <string>

#include "lode/core/result.h"
#include "lode/io/image.h"
#include "lode/io/sample_storage.h"

namespace lode::io {

/// NIfTI-1 and NIfTI-2, .nii or .hdr with .img, each as it is or with .gz; either byte order.
/// The frame is RAS by the standard when sform or (else) qform says where the grid lies; with
/// neither it is unknown. Slope and intercept are passed on, RGB excepted.
/// https://nifti.nimh.nih.gov/nifti-1/documentation
[[nodiscard]] Result<Image> read_nifti(const std::string& path, const SampleStorage& storage);

}  // namespace lode::io
