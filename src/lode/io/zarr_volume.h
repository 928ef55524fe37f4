#pragma once

#include <memory>
#include <string>

#include "lode/core/result.h"
#include "lode/core/volume.h"
#include "lode/io/volume_reader.h"

namespace lode::io {

/// Opens a directory that is a Zarr array of two to five axes, or a group that holds some. The last
/// axis is x, those before it are y and z (for OME-Zarr, where the axes have types, as many as are
/// spatial). The ones in front of these are time and component: see ReadOptions. Chunks are decoded
/// when their samples are read. Fails, naming the directory or the file in it.
[[nodiscard]] Result<std::unique_ptr<VolumeSource>> open_zarr(const std::string& path,
                                                              const ReadOptions& options);

/// Reads the metadata of the array that open_zarr would open, or of the first.
[[nodiscard]] Result<FileDescription> describe_zarr(const std::string& path,
                                                    const ReadOptions& options);

}  // namespace lode::io
