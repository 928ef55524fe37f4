#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "lode/core/result.h"
#include "lode/core/scalar_type.h"
#include "lode/io/byte_stream.h"
#include "lode/io/image.h"
#include "lode/io/sample_storage.h"
#include "lode/io/text_cursor.h"

namespace lode::io {

/// Reads `n_bytes` worth of numbers of `type` written as text, into native bytes. Checks first
/// that the stream is long enough to hold them. Integers may be written as 12.0; out of range or
/// fractional ones fail.
[[nodiscard]] Result<std::vector<std::byte>> read_text_samples(TextCursor& cursor,
                                                               std::uint64_t n_left,
                                                               ScalarType type,
                                                               std::uint64_t n_bytes);

/// The byte order of this machine, which decoded text has.
[[nodiscard]] ByteOrder native_byte_order();

/// Where text samples start, which reach to the file's end at most, and what they are to become.
struct TextSamples {
  InputFilePtr file;
  std::uint64_t offset = 0;
  ScalarType type = ScalarType::uint8;
  std::uint64_t n_bytes = 0;
};

/// Text samples decoded into memory; fails when they exceed the storage's limit.
[[nodiscard]] Result<std::unique_ptr<SampleStore>> load_text(const TextSamples& samples,
                                                             const SampleStorage& storage);

}  // namespace lode::io
