#pragma once

#include <memory>

#include "lode/core/parallel.h"
#include "lode/core/volume.h"
#include "lode/io/zarr_array.h"

namespace lode::io {

/// A volume inside an array: all of its last two or three axes (y, x or z, y, x), at one place of
/// each axis before them.
struct ZarrView {
  ZarrArray array;
  ZarrShape place;  ///< Along the leading axes.
};

/// Serves boxes of the view; info.grid and info.type fit it. Each read decodes the chunks that meet
/// its box in parallel. All are kept where they take no more than `max_cache_bytes` (1 GiB where
/// that is no limit). Else those that reach beyond the box are kept for the next read: up to 64 MiB
/// of them, or one layer of chunks along x and y where that takes more, but never above 1 GiB or
/// `max_cache_bytes`.
[[nodiscard]] std::unique_ptr<VolumeSource> make_zarr_source(ZarrView view, VolumeInfo info,
                                                             Threads threads,
                                                             std::size_t max_cache_bytes);

}  // namespace lode::io
