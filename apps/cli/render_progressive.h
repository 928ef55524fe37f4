#pragma once

#include "input.h"
#include "output_folder.h"
#include "outputs.h"
#include "progressive_options.h"

namespace lode::cli {

void add_frame_options(CLI::App& app, ProgressiveArguments& arguments);

[[nodiscard]] Result<int> to_frames_per_step(const ProgressiveArguments& arguments);

/// The part of `lode render` that draws a surface on its way from coarse to fine.
struct FramesJob {
  const OutputFolder& folder;
  int frames_per_step = 1;
  const ExtractOptions& extraction;
  const RenderOptions& picture;  ///< With a camera.
  const Input& input;
};

/// Draws frame-0000.png, the first step, and frames_per_step more for each of the others, the last
/// of them the step itself. Returns what to report.
[[nodiscard]] Result<Json> draw_frames(const FramesJob& job, Session& session, OutputSet& outputs);

}  // namespace lode::cli
