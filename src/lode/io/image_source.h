#pragma once

#include <memory>
#include <span>
#include <string>

#include "lode/core/result.h"
#include "lode/core/volume.h"
#include "lode/io/image.h"
#include "lode/io/volume_reader.h"

namespace lode::io {

/// The place in `names` of the field that the options pick; fails, listing them, when there are
/// several and no choice, or none of that name.
[[nodiscard]] Result<std::size_t> choose_field(const std::string& path,
                                               std::span<const std::string> names,
                                               const ReadOptions& options);
/// The time that the options pick; fails when there are several and no choice, or it is none.
[[nodiscard]] Result<std::int64_t> choose_time(const std::string& path, std::int64_t n_times,
                                               const ReadOptions& options);
/// Fails unless options.nodata is finite or missing.
[[nodiscard]] Result<void> check_nodata(const std::string& path, const ReadOptions& options);

/// What the options name, else the file; as labels.
[[nodiscard]] Units chosen_units(const Units& of_file, const ReadOptions& options);

/// The field that the options pick; fails, listing them, when there are several and no choice, or
/// none of that name.
[[nodiscard]] Result<const ImageField*> choose_field(const Image& image,
                                                     const ReadOptions& options);

/// Makes the scalar source that the options pick out of an image: field, time, component or
/// magnitude, with slope and intercept applied. The type stays as stored unless values are
/// computed: then it is float32 for samples of up to 16 bits and float32 ones, else float64.
[[nodiscard]] Result<std::unique_ptr<VolumeSource>> make_image_source(const Image& image,
                                                                      const ReadOptions& options);

}  // namespace lode::io
