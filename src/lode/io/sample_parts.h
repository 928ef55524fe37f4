#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "lode/core/result.h"
#include "lode/io/byte_stream.h"
#include "lode/io/image.h"

namespace lode::io {

/// Samples in parts of `n_bytes_each`, numbered from 0, one after the other: the data files of one
/// volume. A part is opened when a read comes to it and closed when one leaves it, since slices may
/// be more than a process may hold open.
template <typename Part>
struct SampleParts {
  std::uint64_t n_bytes_each = 0;
  std::size_t n_parts = 0;
  std::function<Result<std::unique_ptr<Part>>(std::size_t part)> open;
};

[[nodiscard]] std::unique_ptr<SampleStore> make_parts_store(SampleParts<SampleStore> parts);

[[nodiscard]] std::unique_ptr<ByteStream> make_parts_stream(SampleParts<ByteStream> parts);

}  // namespace lode::io
