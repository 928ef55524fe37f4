#pragma once

#include <cstdint>
#include <memory>

#include "lode/core/result.h"
#include "lode/io/byte_stream.h"
#include "lode/io/image.h"
#include "lode/io/input_file.h"
#include "lode/io/sample_storage.h"

namespace lode::io {

/// Samples that are one gzip or zlib stream, from `offset` to the file's end.
struct DeflatedSamples {
  InputFilePtr file;
  std::uint64_t offset = 0;
  std::uint64_t n_skipped = 0;  ///< Bytes before the samples, counted after decompression.
  std::uint64_t n_bytes = 0;    ///< Of the samples, decompressed; the stream holds no more.
};

/// The samples as a stream, whose last read fails when more follow. Fails when the file is too
/// small to hold them.
[[nodiscard]] Result<std::unique_ptr<ByteStream>> inflated_stream(const DeflatedSamples& samples);

/// Decodes the samples into memory where the storage holds them, and fails if they are damaged or
/// not as many as promised; else makes a spooled store, whose reads find that out.
[[nodiscard]] Result<std::unique_ptr<SampleStore>> load_inflated(const DeflatedSamples& samples,
                                                                 const SampleStorage& storage);

}  // namespace lode::io
