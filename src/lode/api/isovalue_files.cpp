#include "lode/api/isovalue_files.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <utility>

#include "lode/api/files.h"
#include "lode/core/expects.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/core/surface_sink.h"
#include "lode/io/surface_stream.h"

namespace lode {
namespace {

using Note = std::function<io::SurfaceWriteOptions(const ExtractReport&, double)>;
using Streams = std::vector<std::unique_ptr<io::SurfaceStream>>;

/// Hands a surface whose isovalues come one after the other on to a sink for each.
class IsovalueSplitter final : public SurfaceSink {
 public:
  IsovalueSplitter(const std::vector<double>& isovalues, const Streams& streams) {
    for (std::size_t i = 0; i < isovalues.size(); ++i)
      parts_.push_back({isovalues[i], streams[i].get()});
  }

  [[nodiscard]] Result<void> add(SurfacePiece piece) override {
    if (piece.surface.positions.empty()) return {};
    // Of one isovalue vertices have none.
    const auto part =
        piece.surface.isovalues.empty()
            ? parts_.begin()
            : std::ranges::find(parts_, piece.surface.isovalues.front(), &Part::isovalue);
    LODE_EXPECTS(part != parts_.end());
    if (part->n == 0) part->first = piece.first_new;
    part->n += static_cast<std::uint32_t>(piece.n_new());
    n_ += static_cast<std::uint32_t>(piece.n_new());
    piece.first_new -= part->first;
    for (std::uint32_t& vertex : piece.earlier) vertex -= part->first;
    return part->sink->add(std::move(piece));
  }
  void set_normals(std::span<const VertexNormal> normals) override {
    for (const Part& part : parts_) {
      std::vector<VertexNormal> own;
      for (const VertexNormal& normal : normals)
        if (normal.vertex >= part.first && normal.vertex - part.first < part.n)
          own.push_back({normal.vertex - part.first, normal.normal});
      if (!own.empty()) part.sink->set_normals(own);
    }
  }
  [[nodiscard]] std::uint32_t n_vertices() const override { return n_; }

 private:
  struct Part {
    double isovalue;
    SurfaceSink* sink;
    std::uint32_t first = 0;  ///< The number of its first vertex in the whole.
    std::uint32_t n = 0;      ///< Vertices so far.
  };
  std::vector<Part> parts_;
  std::uint32_t n_ = 0;
};

template <typename Cell>
void add_cells_at(const std::vector<Cell>& from, const std::vector<std::uint32_t>& numbers,
                  std::vector<Cell>& to) {
  for (Cell cell : from) {
    if (numbers[cell[0]] == UINT32_MAX) continue;
    for (std::uint32_t& vertex : cell) vertex = numbers[vertex];
    to.push_back(cell);
  }
}

/// An isovalue's vertices and cells, in the order that they have.
Surface part_at(const Surface& all, double isovalue) {
  if (all.isovalues.empty()) return all;
  Surface part;
  part.origin = all.origin;
  std::vector<std::uint32_t> numbers(all.positions.size(), UINT32_MAX);
  for (std::size_t v = 0; v < numbers.size(); ++v) {
    if (all.isovalues[v] != isovalue) continue;
    numbers[v] = static_cast<std::uint32_t>(part.positions.size());
    part.positions.push_back(all.positions[v]);
    if (!all.normals.empty()) part.normals.push_back(all.normals[v]);
  }
  add_cells_at(all.triangles, numbers, part.triangles);
  add_cells_at(all.lines, numbers, part.lines);
  return part;
}

Result<ExtractReport> stream_to_files(const Dataset& dataset, const ExtractOptions& options,
                                      std::span<const std::string> paths, const Note& note,
                                      Progress& progress) {
  const std::uint64_t limit =
      options.memory_limit > 0 ? options.memory_limit : physical_memory() / 4;
  Streams streams;
  for (const std::string& path : paths) {
    LODE_TRY(auto stream,
             io::stream_surface(path, limit / 8 / paths.size(), options.threads, progress));
    streams.push_back(std::move(stream));
  }
  IsovalueSplitter splitter(options.isovalues, streams);
  LODE_TRY(ExtractReport report, dataset.extract(options, splitter, progress));
  const Stopwatch writing;
  for (std::size_t i = 0; i < streams.size(); ++i)
    LODE_CHECK(streams[i]->finish(note(report, options.isovalues[i])));
  report.seconds.write = writing.seconds();
  return report;
}

Result<ExtractReport> write_parts(const Dataset& dataset, const ExtractOptions& options,
                                  std::span<const std::string> paths, const Note& note,
                                  Progress& progress) {
  Surface all;
  LODE_TRY(ExtractReport report, dataset.extract(options, all, progress));
  const Stopwatch writing;
  const auto note_of = [&](double isovalue) { return note(report, isovalue); };
  LODE_CHECK(write_isovalue_files(all, options.isovalues, paths, note_of, progress));
  report.seconds.write = writing.seconds();
  return report;
}

}  // namespace

Result<bool> are_extracted_together(const Dataset& dataset, const ExtractOptions& options,
                                    const std::string& path, Progress& progress) {
  if (options.isovalues.size() < 2 || !dataset.takes_several_isovalues(options)) return false;
  if (options.max_distance || options.keep_topology || options.simplify != Simplify::off)
    return true;
  if (!io::can_stream(path)) return false;
  return dataset.comes_in_pieces(options, progress);
}

Result<ExtractReport> extract_to_files(const Dataset& dataset, const ExtractOptions& options,
                                       std::span<const std::string> paths, const Note& note,
                                       Progress& progress) try {
  LODE_EXPECTS(!paths.empty() && paths.size() == options.isovalues.size());
  const Stopwatch all;
  LODE_TRY(const bool comes_in_pieces, dataset.comes_in_pieces(options, progress));
  LODE_TRY(ExtractReport report, comes_in_pieces && io::can_stream(paths.front())
                                     ? stream_to_files(dataset, options, paths, note, progress)
                                     : write_parts(dataset, options, paths, note, progress));
  report.seconds.total = all.seconds() - report.seconds.write;
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the surface", paths.front());
}

Result<void> write_isovalue_files(const Surface& all, std::span<const double> isovalues,
                                  std::span<const std::string> paths,
                                  const std::function<io::SurfaceWriteOptions(double)>& note,
                                  Progress& progress) try {
  LODE_EXPECTS(paths.size() == isovalues.size());
  for (std::size_t i = 0; i < paths.size(); ++i)
    LODE_CHECK(write_surface(paths[i], part_at(all, isovalues[i]), note(isovalues[i]), progress));
  return {};
} catch (const std::bad_alloc&) {
  return out_of_memory("write the surfaces", paths.front());
}

Result<void> check_isovalues_of(const std::string& path, std::vector<double> isovalues) {
  if (isovalues.size() < 2 || !io::has_narrow_isovalues(path)) return {};
  std::ranges::sort(isovalues);
  for (std::size_t i = 0; i < isovalues.size(); ++i) {
    const auto narrow = static_cast<float>(isovalues[i]);
    if (!std::isfinite(narrow))
      return fail("{}: expected isovalues that float32 holds, as glTF has no others, got {}", path,
                  isovalues[i]);
    if (i > 0 && static_cast<float>(isovalues[i - 1]) == narrow)
      return fail(
          "{}: expected isovalues that differ as float32, as glTF has no others, got {} and {}",
          path, isovalues[i - 1], isovalues[i]);
  }
  return {};
}

Result<Surface> read_isovalue_files(std::span<const std::string> paths,
                                    std::span<const double> isovalues) try {
  if (paths.size() != isovalues.size())
    return fail("expected an isovalue for each of {} surfaces, got {}", paths.size(),
                isovalues.size());
  Surface all;
  SurfaceCollector collector(all);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    SurfacePiece piece;
    LODE_TRY(piece.surface, read_surface(paths[i]));
    Surface& one = piece.surface;
    if (!all.positions.empty() && !one.positions.empty() && one.origin != all.origin)
      return fail("{}: expected coordinates from {} {} {} as those of {}, got from {} {} {}",
                  paths[i], all.origin[0], all.origin[1], all.origin[2], paths.front(),
                  one.origin[0], one.origin[1], one.origin[2]);
    if (one.positions.empty()) continue;
    one.normals.clear();
    one.isovalues.assign(one.positions.size(), isovalues[i]);
    piece.first_new = collector.n_vertices();
    LODE_CHECK(collector.add(std::move(piece)));
  }
  return all;
} catch (const std::bad_alloc&) {
  return out_of_memory("read the surfaces", paths.empty() ? std::string() : paths.front());
}

}  // namespace lode
