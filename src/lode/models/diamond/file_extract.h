#pragma once

#include <functional>

#include "lode/core/surface_sink.h"
#include "lode/models/diamond/block_order.h"
#include "lode/models/diamond/extract.h"
#include "lode/models/diamond/file_parts.h"
#include "lode/models/diamond/isovalue_list.h"

namespace lode::diamond {

/// Where pieces of an isovalue's surface go, by its number; null: nowhere, from now on. Is called
/// from the thread that extracts alone: it may let go of surfaces.
using SinkOfIsovalue = std::function<SurfaceSink*(std::size_t)>;

/// Is shown a chunk's samples before its pieces go to their sinks.
template <int D>
using SeePart = std::function<void(FilePart<D>&)>;

/// extract_isosurface(), of all isovalues in one pass, from a file, chunk by chunk: blocks are read
/// where bricks that a surface may cross need them, and not kept. The same surfaces, vertex by
/// vertex, as from memory with a tolerance above 0; sinks take each chunk's pieces. `query`: its
/// isovalue does not count; nodes are wanted of all isovalues. Where there are holes, all samples
/// of such bricks are read, and of coarser simplices one cell's, as only they tell what is removed.
/// Cubes within a tolerance, or beside holes, depend on the bricks round a chunk, which are loaded
/// with it then. In memory are `field`, one chunk and all surfaces' pieces of it, vertices that
/// later chunks share, and what `blocks` keeps.
template <int D>
[[nodiscard]] Result<IsosurfaceReport> extract_from_file(
    const CoarseField<D>& field, store::BlockCache& blocks, const IsovalueList& isovalues,
    const IsosurfaceQuery& query, const SinkOfIsovalue& sink_of, Progress& progress,
    const SeePart<D>& see_part = {});

/// Chunks that have a vertex in common come at most so many pieces after one another.
template <int D>
[[nodiscard]] std::size_t n_pieces_apart(const Shape<D>& shape) {
  const Index<D> n = chunk_counts<D>(shape);
  std::size_t sum = 1;  // with the piece of coarser simplices
  std::size_t stride = 1;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    sum += stride;
    stride *= as_size(n[i]);
  }
  return sum;
}

}  // namespace lode::diamond
