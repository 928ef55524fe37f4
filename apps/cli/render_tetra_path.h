#pragma once

#include <vector>

#include "output_folder.h"
#include "outputs.h"
#include "tetra_picture.h"
#include "text.h"

namespace lode::cli {

/// The part of `lode render` of a mesh of cells that follows a camera: a frame for each of its
/// places, which is the picture through that camera, but of a mesh that is refined from the last
/// one's, with only the splits and collapses that they differ in.
struct TetraPathJob {
  const TetraPictureJob& picture;
  const TetraPicturePlan& plan;
  const std::vector<Camera>& cameras;
  const OutputFolder& folder;
  const TetraInput& input;
};

/// Draws frame-0000.png and so on. Returns what to report.
[[nodiscard]] Result<Json> draw_tetra_path(const TetraPathJob& job, Session& session,
                                           OutputSet& outputs);

/// What draw_tetra_path() returned, in words. `job`: that of the picture.
void add_tetra_path(const TetraPictureJob& job, const Json& path, Table& table);

}  // namespace lode::cli
