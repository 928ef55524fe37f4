#pragma once

#include "lode/core/surface_sink.h"
#include "lode/models/diamond/extract.h"
#include "lode/models/diamond/file_parts.h"

namespace lode::diamond {

/// extract_isosurface() from a file, chunk by chunk: blocks are read where bricks that the surface
/// may cross need them, and not kept. The same surface, vertex by vertex, as from memory with a
/// tolerance above 0; `surface` takes each chunk's piece. Where there are holes, all samples of
/// such bricks are read, and of coarser simplices one cell's, as only they tell what is removed. In
/// memory are `field`, one chunk and its piece, vertices that later chunks share, and what `blocks`
/// keeps.
template <int D>
[[nodiscard]] Result<IsosurfaceReport> extract_from_file(const CoarseField<D>& field,
                                                         store::BlockCache& blocks,
                                                         const IsosurfaceQuery& query,
                                                         SurfaceSink& surface, Progress& progress);

}  // namespace lode::diamond
