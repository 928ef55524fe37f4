#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/io/zarr_array.h"

namespace lode::io {

/// What a chunk decodes to. Its bytes are known not to overflow.
struct ZarrChunkForm {
  ZarrShape shape;
  ScalarType type = ScalarType::uint8;
  ZarrFill fill{};

  [[nodiscard]] std::uint64_t n_bytes() const;
};

/// Fails when `n_stored` bytes cannot be a chunk of that form: too few for the best a compressor
/// can do, or more than the worst. Called before memory is taken for either; `name` is the chunk's
/// in messages.
[[nodiscard]] Result<void> check_stored_size(const std::string& name, const ZarrCodecs& codecs,
                                             const ZarrChunkForm& form, std::uint64_t n_stored);

/// The samples of a chunk, its last axis fastest, in native byte order. Fails, naming the chunk,
/// unless `stored` decodes to exactly as many as its form says.
[[nodiscard]] Result<std::vector<std::byte>> decode_chunk(const std::string& name,
                                                          const ZarrCodecs& codecs,
                                                          const ZarrChunkForm& form,
                                                          std::span<const std::byte> stored);

}  // namespace lode::io
