#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/io/image.h"
#include "lode/io/input_file.h"
#include "lode/io/sample_storage.h"

namespace lode::io {

enum class NrrdEncoding { raw, gzip, text, hex };

/// Where the samples are and how they are written.
struct NrrdData {
  InputFilePtr file;               ///< With or without a header; none where there are several.
  std::vector<std::string> paths;  ///< Of several data files, in the order of their samples.
  IoTallyPtr tally;                ///< Of all files.
  std::uint64_t offset = 0;        ///< Of the first byte after the header.
  std::int64_t line_skip = 0;
  std::int64_t byte_skip = 0;  ///< -1: the samples are the last bytes of the file (raw only).
  NrrdEncoding encoding = NrrdEncoding::raw;
  ScalarType type = ScalarType::uint8;
};

/// Finds or decodes the `n_bytes` of all samples. Several files are read into memory one after the
/// other; beyond the storage's limit, raw ones are opened as reads come to them, and gzip ones
/// decoded into one spool.
[[nodiscard]] Result<std::unique_ptr<SampleStore>> load_nrrd_data(const NrrdData& data,
                                                                  std::uint64_t n_bytes,
                                                                  const SampleStorage& storage);

}  // namespace lode::io
