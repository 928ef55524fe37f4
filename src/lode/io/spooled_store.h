#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "lode/core/result.h"
#include "lode/io/byte_stream.h"
#include "lode/io/image.h"
#include "lode/io/sample_storage.h"

namespace lode::io {

/// Samples that only come front to back, too many for memory.
struct ForwardSamples {
  std::string path;                    ///< What messages start with.
  std::unique_ptr<ByteStream> stream;  ///< Of the samples' bytes, decoded.
  std::uint64_t n_bytes = 0;           ///< Of the stream.
  IoTallyPtr tally;
};

/// A store that decodes as far as it is asked to, keeps what it decoded in a spool file, and reads
/// from there what it is asked for again: a first pass in ascending order gets every byte straight
/// from the decoder. Bytes are decoded once, written once, and read back as often as they are read
/// again. What is wrong with the stream appears at the read that reaches it, and at every one that
/// goes as far afterwards. Fails when the storage's directory takes no file.
[[nodiscard]] Result<std::unique_ptr<SampleStore>> make_spooled_store(ForwardSamples samples,
                                                                      const SampleStorage& storage);

}  // namespace lode::io
