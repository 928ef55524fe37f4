#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/surface_sink.h"
#include "lode/io/surface_file.h"

namespace lode::io {

/// A surface file that is written piece by piece, with the bytes that write_surface() gives the
/// whole surface. Formats whose vertices all come before the cells (PLY, VTP) wait for their ends
/// in memory, or in nameless files beside the output once they are large; STL goes to the output.
class SurfaceStream : public SurfaceSink {
 public:
  /// After the last piece: the file appears, whole or not at all.
  [[nodiscard]] virtual Result<void> finish(const SurfaceWriteOptions& options) = 0;
};

/// Whether the format that the extension names can be written piece by piece: .ply, .stl, .vtp.
[[nodiscard]] bool can_stream(const std::string& path);

/// memory_bytes: about what may wait in memory. threads: of what is done as pieces come.
/// `progress`: of finish(), and to be cancelled.
[[nodiscard]] Result<std::unique_ptr<SurfaceStream>> stream_surface(const std::string& path,
                                                                    std::uint64_t memory_bytes,
                                                                    Threads threads,
                                                                    Progress& progress);

}  // namespace lode::io
