#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/io/byte_stream.h"
#include "lode/io/image.h"
#include "lode/io/input_file.h"

namespace lode::io {

/// How a VTK XML file writes the counts before its data: UInt32 or UInt64.
struct VtkCounts {
  ByteOrder byte_order = ByteOrder::little;
  std::size_t n_bytes = 4;
};

[[nodiscard]] Result<std::uint64_t> read_vtk_count(ByteStream& stream, VtkCounts counts);

/// The blocks that compressed data consist of, each a zlib stream of its own. All but the last
/// hold equally much.
struct VtkBlocks {
  std::string path;                 ///< What messages start with.
  std::vector<std::uint64_t> ends;  ///< Of the blocks, in compressed bytes from the first one.
  std::uint64_t n_bytes_each = 0;   ///< Decompressed.
  std::uint64_t n_bytes_last = 0;
  std::uint64_t n_bytes = 0;  ///< Of all.

  [[nodiscard]] std::uint64_t begin_of(std::size_t i) const { return i == 0 ? 0 : ends[i - 1]; }
  [[nodiscard]] std::uint64_t n_compressed(std::size_t i) const { return ends[i] - begin_of(i); }
  [[nodiscard]] std::uint64_t n_decoded(std::size_t i) const {
    return i + 1 == ends.size() ? n_bytes_last : n_bytes_each;
  }
  /// Whether single blocks may be decoded for the sake of a few rows: none is above 256 KiB.
  [[nodiscard]] bool are_small() const;
};

/// The table in front of the blocks, after which `stream` stands at the first of them. Fails unless
/// they make up `n_bytes`, can do so, and all fit into what the stream has left.
[[nodiscard]] Result<VtkBlocks> read_vtk_blocks(const std::string& path, ByteStream& stream,
                                                VtkCounts counts, std::uint64_t n_bytes);

/// What the blocks in `compressed` expand to, as a stream that holds little of them at a time.
[[nodiscard]] std::unique_ptr<ByteStream> make_vtk_block_stream(
    std::unique_ptr<ByteStream> compressed, VtkBlocks blocks);

/// Decodes each block, found in `file` from `offset` on, when a read needs it, and remembers the
/// last one that it did not need as a whole. For small blocks.
[[nodiscard]] std::unique_ptr<SampleStore> make_vtk_block_store(InputFilePtr file,
                                                                std::uint64_t offset,
                                                                VtkBlocks blocks);

}  // namespace lode::io
