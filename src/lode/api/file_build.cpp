#include "lode/api/file_build.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <new>

#include "lode/core/out_of_memory.h"
#include "lode/models/diamond/stream_build.h"

namespace lode {

std::uint64_t physical_memory() {
  const long pages = ::sysconf(_SC_PHYS_PAGES);
  const long page_bytes = ::sysconf(_SC_PAGESIZE);
  if (pages <= 0 || page_bytes <= 0) return 0;
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes);
}

namespace {

/// The file is in its place: what fails here does not undo that, and says so.
Result<DatasetInfo> describe_written(const std::string& path, const FileBuildOptions& options) try {
  if (options.has_part != nullptr) *options.has_part = false;
  const auto dataset = Dataset::open(path, options.threads);
  if (dataset) return dataset->describe();
  return fail("{}: it is written, but cannot be read again: {}", path, dataset.error().message);
} catch (const std::bad_alloc&) {
  return out_of_memory("describe what is written there", path);
}

}  // namespace

std::string part_path(const std::string& output) { return AtomicFile::part_path(output); }

Result<FileBuildReport> build_file(VolumeSource& source, const std::string& path,
                                   const FileBuildOptions& options, Progress& progress) try {
  const auto start = std::chrono::steady_clock::now();
  FileBuildReport report;
  report.memory_limit = options.memory_limit > 0 ? options.memory_limit : physical_memory() / 4;
  const diamond::StreamSettings settings{.threads = options.threads,
                                         .memory_limit = report.memory_limit,
                                         .unfinished = options.unfinished,
                                         .has_part = options.has_part,
                                         .chunks_per_part = 0};
  const Index3 dims = source.info().grid.dims;
  const bool is_flat = std::min({dims[0], dims[1], dims[2]}) == 1;
  LODE_TRY(const auto done, is_flat ? diamond::build_file<2>(source, path, settings, progress)
                                    : diamond::build_file<3>(source, path, settings, progress));
  LODE_TRY(report.info, describe_written(path, options));
  report.file_bytes = done.file_bytes;
  report.samples_bytes_read = done.bytes_read;
  report.io = done.io;
  report.n_parts = done.n_parts;
  report.n_chunks_resumed = done.n_chunks_resumed;
  report.seconds = {.total = 0,
                    .scan = done.scan_seconds,
                    .read = done.read_seconds,
                    .build = done.build_seconds,
                    .write = done.write_seconds};
  report.seconds.total =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("build the file", path);
}

}  // namespace lode
