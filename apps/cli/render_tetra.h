#pragma once

#include <CLI/CLI.hpp>

#include "command.h"
#include "tetra_picture.h"

namespace lode::cli {

void add_tetra_picture_options(CLI::App& app, TetraPictureArguments& arguments);

/// Looks at the arguments alone, and at the files of cameras.
[[nodiscard]] Result<void> check_tetra_picture(const TetraPictureJob& job);
/// Builds the hierarchy of a mesh of cells in memory, or opens its file, and draws the mesh of a
/// query: its volume, isosurfaces and sections. With a path of cameras also a frame for each.
[[nodiscard]] Result<Outcome> run_tetra_picture(const TetraPictureJob& job, Session& session);

[[nodiscard]] Json camera_json(const Camera& camera);

}  // namespace lode::cli
