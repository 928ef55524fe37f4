#include "render_progressive.h"

#include <fmt/format.h>

#include "parse.h"

namespace lode::cli {
namespace {

constexpr std::int64_t kMostFramesPerStep = 1000;

/// Draws frames and numbers them.
class FrameWriter {
 public:
  FrameWriter(const FramesJob& job, Progress& progress, OutputSet& outputs)
      : job_(job), progress_(progress), outputs_(outputs) {}

  [[nodiscard]] int n_frames() const { return n_frames_; }

  Result<void> draw(const Surface& surface) {
    const std::string path = job_.folder.path_of(fmt::format("frame-{:04}.png", n_frames_));
    const Box3d bounds = job_.input.info.volume.grid.world_bounds();
    LODE_TRY(const Image image, render_surface(surface, bounds, job_.picture, progress_));
    if (progress_.is_cancelled()) return cancelled_error();
    LODE_CHECK(write_png(image, path));
    outputs_.add(path);
    ++n_frames_;
    return {};
  }

 private:
  const FramesJob& job_;
  Progress& progress_;
  OutputSet& outputs_;
  int n_frames_ = 0;
};

}  // namespace

void add_frame_options(CLI::App& app, ProgressiveArguments& arguments) {
  add_progressive_option(app, arguments,
                         "Also draw the surface from coarse to fine, frame-0000.png and so on, to "
                         "a new or empty directory");
  app.add_option("--frames-per-step", arguments.frames_per_step,
                 "Frames on the way from a step to the next (default: 8)")
      ->type_name("N")
      ->group("Steps");
}

Result<int> to_frames_per_step(const ProgressiveArguments& arguments) {
  if (arguments.frames_per_step.empty()) return 8;
  LODE_TRY(const auto n,
           parse_integer("--frames-per-step", arguments.frames_per_step, 1, kMostFramesPerStep));
  return static_cast<int>(n);
}

Result<Json> draw_frames(const FramesJob& job, Session& session, OutputSet& outputs) {
  LODE_TRY(auto surfaces,
           ProgressiveSurface::begin(job.input.dataset, job.extraction, session.progress()));
  FrameWriter frames(job, session.progress(), outputs);
  Json steps = Json::array();
  while (true) {
    LODE_TRY(const bool has_step, surfaces.advance(session.progress()));
    if (!has_step) break;
    const int n = surfaces.step().is_first ? 1 : job.frames_per_step;
    for (int i = 1; i < n; ++i) LODE_CHECK(frames.draw(surfaces.surface(1.0 * i / n)));
    const Surface surface = surfaces.surface(1);
    LODE_CHECK(frames.draw(surface));
    Json entry;
    entry["frame"] = frames.n_frames() - 1;
    entry.update(step_json(surfaces.step(), surface));
    steps.push_back(std::move(entry));
  }
  Json report;
  report["frames"] = frames.n_frames();
  report["frames_per_step"] = job.frames_per_step;
  report["steps"] = std::move(steps);
  return report;
}

}  // namespace lode::cli
