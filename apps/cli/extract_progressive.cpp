#include "extract_progressive.h"

#include <fmt/format.h>

#include <filesystem>

#include "salvage.h"

namespace lode::cli {
namespace {

Result<void> write_step(const StepsJob& job, const ProgressiveStep& step, const Surface& surface,
                        const std::string& path, Progress& progress) {
  return write_surface(
      path, surface,
      {.comment = fmt::format("Lode {}: isovalue {}, step of max_error {}, achieved_error {}{}{}",
                              LODE_VERSION, job.options.isovalues.front(), step.max_error,
                              step.achieved_error, units_comment(job.input),
                              salvage_comment(job.input.dataset.salvaged())),
       .frame = job.input.info.volume.grid.frame,
       .threads = job.options.threads},
      progress);
}

}  // namespace

Result<Json> write_steps(const StepsJob& job, Session& session, OutputSet& outputs) {
  Progress& progress = session.progress();
  LODE_TRY(auto surfaces, ProgressiveSurface::begin(job.input.dataset, job.options, progress));
  Json index;
  index["isovalue"] = job.options.isovalues.front();
  index["steps"] = Json::array();
  while (true) {
    LODE_TRY(const bool has_step, surfaces.advance(progress));
    if (!has_step) break;
    const Surface surface = surfaces.surface(1);
    const std::string name = fmt::format("step-{:03}{}", index["steps"].size(),
                                         std::filesystem::path(job.output).extension().string());
    LODE_CHECK(write_step(job, surfaces.step(), surface, job.folder.path_of(name), progress));
    outputs.add(job.folder.path_of(name));
    Json entry;
    entry["file"] = name;
    entry.update(step_json(surfaces.step(), surface));
    index["steps"].push_back(std::move(entry));
  }
  LODE_CHECK(write_text(job.folder.path_of("index.json"), index.dump(2) + "\n", progress));
  outputs.add(job.folder.path_of("index.json"));
  return index;
}

}  // namespace lode::cli
