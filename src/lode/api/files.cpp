#include "lode/api/files.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>
#include <span>
#include <string_view>
#include <system_error>

#include "lode/core/atomic_file.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/io/surface_stream.h"
#include "lode/mappers/surface_edits.h"
#include "lode/store/header.h"

namespace lode {
namespace {

bool has_extension(const std::string& path, std::string_view wanted) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension == wanted;
}

/// Hands reads on and remembers whether one failed: the reader's messages name the file.
class WatchedSource final : public VolumeSource {
 public:
  explicit WatchedSource(VolumeSource& source) : source_(source) {}

  [[nodiscard]] const VolumeInfo& info() const override { return source_.info(); }
  [[nodiscard]] Result<void> read(const IndexBox& box, std::span<std::byte> out) override {
    auto status = source_.read(box, out);
    has_failed_ = has_failed_ || !status;
    return status;
  }
  [[nodiscard]] IoCounts io() const override { return source_.io(); }
  [[nodiscard]] std::uint64_t memory_bytes() const override { return source_.memory_bytes(); }
  [[nodiscard]] ReadUnit read_unit() const override { return source_.read_unit(); }
  void obey(const Progress* progress) override { source_.obey(progress); }
  [[nodiscard]] bool has_failed() const { return has_failed_; }

 private:
  VolumeSource& source_;
  bool has_failed_ = false;
};

}  // namespace

bool is_lode_path(const std::string& path) {
  return has_extension(path, ".lode") || store::starts_as_lode(path);
}

bool is_cell_mesh_path(const std::string& path) {
  for (const char* const extension : {".vtu", ".vts", ".msh", ".mesh", ".meshb"})
    if (has_extension(path, extension)) return true;
  if (!has_extension(path, ".vtk")) return false;
  constexpr std::size_t kHeader = 1024;
  std::string head(kHeader, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(kHeader));
  head.resize(static_cast<std::size_t>(file.gcount()));
  return head.find("DATASET UNSTRUCTURED_GRID") != std::string::npos ||
         head.find("DATASET STRUCTURED_GRID") != std::string::npos;
}

bool holds_tetrahedra(const std::string& path) {
  return is_cell_mesh_path(path) || (is_lode_path(path) && TetraDataset::is_model_of(path));
}

Result<Surface> read_surface(const std::string& path) {
  LODE_TRY(PlacedSurface placed, read_placed_surface(path));
  return std::move(placed.surface);
}

Result<PlacedSurface> read_placed_surface(const std::string& path) try {
  LODE_TRY(PlacedSurface placed, io::read_placed_surface(path));
  if (has_extension(path, ".stl")) split_pinched_vertices(placed.surface);
  return placed;
} catch (const std::bad_alloc&) {
  return out_of_memory("read the surface", path);
}

Result<ExtractReport> extract_to_file(
    const Dataset& dataset, const ExtractOptions& options, const std::string& path,
    const std::function<SurfaceWriteOptions(const ExtractReport&)>& note, Progress& progress) try {
  const Stopwatch all;
  LODE_TRY(const bool comes_in_pieces, dataset.comes_in_pieces(options, progress));
  if (comes_in_pieces && io::can_stream(path)) {
    const std::uint64_t limit =
        options.memory_limit > 0 ? options.memory_limit : physical_memory() / 4;
    LODE_TRY(const auto stream, io::stream_surface(path, limit / 8, options.threads, progress));
    LODE_TRY(ExtractReport report, dataset.extract(options, *stream, progress));
    report.seconds.total = all.seconds();  // with what was read to find how it comes
    const Stopwatch writing;
    LODE_CHECK(stream->finish(note(report)));
    report.seconds.write = writing.seconds();
    return report;
  }
  Surface surface;
  LODE_TRY(ExtractReport report, dataset.extract(options, surface, progress));
  report.seconds.total = all.seconds();
  const Stopwatch writing;
  LODE_CHECK(write_surface(path, surface, note(report), progress));
  report.seconds.write = writing.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the surface", path);
}

Result<Dataset> open_any(const std::string& path, const ReadOptions& options, Threads threads,
                         Progress& progress) try {
  if (is_lode_path(path)) return Dataset::open(path, threads);
  ReadOptions reading = options;
  reading.threads = threads;
  LODE_TRY(const auto source, open_volume(path, reading));
  return build_opened(path, *source, {.threads = threads}, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("open the file", path);
}

Result<Dataset> build_opened(const std::string& path, VolumeSource& source,
                             const BuildOptions& options, Progress& progress) try {
  WatchedSource watched(source);
  auto dataset = Dataset::build(watched, options, progress);
  if (dataset || watched.has_failed() || progress.is_cancelled()) return dataset;
  return fail("{}: {}", path, dataset.error().message);
} catch (const std::bad_alloc&) {
  return out_of_memory("build the hierarchy", path);
}

Result<FileBuildReport> build_file_from(const std::string& path, VolumeSource& source,
                                        const std::string& output, const FileBuildOptions& options,
                                        Progress& progress) try {
  WatchedSource watched(source);
  auto report = build_file(watched, output, options, progress);
  if (report || watched.has_failed() || progress.is_cancelled()) return report;
  const std::string& message = report.error().message;
  if (message.starts_with(output)) return report;  // the output has been named
  return fail("{}: {}", path, message);
} catch (const std::bad_alloc&) {
  return out_of_memory("build from the file", path);
}

Result<void> write_text(const std::string& path, std::string_view text,
                        const Progress& progress) try {
  LODE_TRY(AtomicFile file, AtomicFile::create(path));
  LODE_CHECK(file.write(text));
  return file.commit(progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("write the file", path);
}

Result<void> check_writable(const std::string& path) try {
  std::error_code status;
  const auto type = std::filesystem::status(path, status).type();
  // Replacing a device or a pipe by a file is never what was meant.
  if (type != std::filesystem::file_type::not_found &&
      type != std::filesystem::file_type::regular &&
      type != std::filesystem::file_type::directory && type != std::filesystem::file_type::none)
    return fail("{}: expected a file name for the output, got a device, pipe or socket", path);
  // Making the temporary is the one test that says what the real write will say.
  if (auto file = AtomicFile::create(path); !file) return file.error();
  return {};
} catch (const std::bad_alloc&) {
  return out_of_memory("find out whether it can be written", path);
}

}  // namespace lode
