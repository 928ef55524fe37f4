#pragma once

#include "extraction_options.h"
#include "input.h"
#include "output_folder.h"
#include "outputs.h"

namespace lode::cli {

/// The options of a moving camera as typed.
struct PathArguments {
  std::string path;
  std::string frames;
  std::string max_error_px;  ///< Empty: one pixel.

  [[nodiscard]] bool is_wanted() const { return !path.empty() || !frames.empty(); }
};

void add_path_options(CLI::App& app, PathArguments& arguments);
/// Refuses a path without frames, and frames without a path.
/// `outputs`: other files, which must not be among the frames.
[[nodiscard]] Result<void> check_path_and_frames(const PathArguments& arguments,
                                                 const std::vector<std::string>& outputs);
/// Of a volume; looks at the arguments alone.
[[nodiscard]] Result<void> check_path(const PathArguments& arguments,
                                      const std::vector<std::string>& outputs,
                                      const ExtractionArguments& extraction);

/// The part of `lode render` of a volume that follows a camera: a frame for each of its places, the
/// surface refined from one to the next as far as it is seen.
struct PathJob {
  const PathArguments& arguments;
  const OutputFolder& folder;
  const ExtractOptions& extraction;
  const RenderOptions& picture;
  const Input& input;
};

/// Draws frame-0000.png and so on. Returns what to report.
[[nodiscard]] Result<Json> draw_path(const PathJob& job, Session& session, OutputSet& outputs);

}  // namespace lode::cli
