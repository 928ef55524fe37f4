#include "lode/io/sample_storage.h"

#include <cstdlib>

#include "lode/io/text.h"

namespace lode::io {

SampleStorage storage_of(const ReadOptions& options) {
  return {.memory_limit = options.memory_limit, .spool_directory = options.spool_directory};
}

std::string spool_directory_of(const SampleStorage& storage) {
  if (!storage.spool_directory.empty()) return storage.spool_directory;
  const char* directory = std::getenv("TMPDIR");
  return directory != nullptr && *directory != '\0' ? directory : "/tmp";
}

Result<void> check_held(const std::string& path, std::string_view kind, std::uint64_t n_bytes,
                        const SampleStorage& storage) {
  if (storage.holds(n_bytes)) return {};
  return fail(
      "{}: {} samples of {} cannot be streamed within a memory limit of {}; convert to raw NRRD",
      path, kind, format_bytes(n_bytes), format_bytes(storage.memory_limit));
}

}  // namespace lode::io
