#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include "lode/core/result.h"
#include "lode/io/volume_reader.h"

namespace lode::io {

/// Where samples go that cannot be read from a file as they are: into memory up to the limit,
/// beyond it into a spool file in the directory.
struct SampleStorage {
  std::uint64_t memory_limit = std::numeric_limits<std::uint64_t>::max();
  std::string spool_directory;  ///< Empty: that of the system's temporary files.

  [[nodiscard]] bool holds(std::uint64_t n_bytes) const { return n_bytes <= memory_limit; }
};

[[nodiscard]] SampleStorage storage_of(const ReadOptions& options);

/// The directory for spools: the one given, else TMPDIR, else /tmp.
[[nodiscard]] std::string spool_directory_of(const SampleStorage& storage);

/// For samples that are decoded into memory or not at all: fails, naming `path` and what the
/// samples are (`kind`, as in "text"), when `n_bytes` of them exceed the limit.
[[nodiscard]] Result<void> check_held(const std::string& path, std::string_view kind,
                                      std::uint64_t n_bytes, const SampleStorage& storage);

}  // namespace lode::io
