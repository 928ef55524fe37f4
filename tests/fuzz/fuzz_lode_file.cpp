// A whole .lode file: opened, described, a coarse surface taken from it block by block, then all of
// it loaded and the surface taken again; what is accepted must not contradict itself.
#include <cmath>

#include "lode/api/dataset.h"
#include "tests/fuzz/fuzz_files.h"

namespace lode::fuzz {
namespace {

void check_message(const Error& error, const std::string& path) {
  expect(error.message.find(path) != std::string::npos, "an error names the file", error.message);
}

/// Half as good as the base is bad; where holes leave that unknown, at full resolution.
ExtractOptions coarse_surface(const DatasetInfo& info) {
  return {.isovalues = {info.range_min / 2 + info.range_max / 2},
          .max_error = std::isfinite(info.base_error) ? info.base_error / 2 : 0,
          .threads = {1}};
}

}  // namespace

void run_lode_file(Input input) {
  const std::string path = fuzz_directory().write("a.lode", input);
  const auto dataset = Dataset::open(path, {1});
  if (!dataset) return check_message(dataset.error(), path);
  const ExtractOptions options = coarse_surface(dataset->describe());
  Progress progress;
  Surface surface;
  if (auto report = dataset->extract(options, surface, progress); !report)
    check_message(report.error(), path);
  if (auto loaded = dataset->load(progress); !loaded) return check_message(loaded.error(), path);
  const auto report = dataset->extract(options, surface, progress);
  if (!report) return check_message(report.error(), path);
  expect(report->achieved_error <= report->max_error, "the tolerance is kept");
}

}  // namespace lode::fuzz
