#include "render_path.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "lode/api/live_query.h"
#include "parse.h"
#include "stopwatch.h"

namespace lode::cli {
namespace {

Result<double> parse_pixels(const std::string& text) {
  if (text.empty()) return 1.0;
  LODE_TRY(const double pixels, parse_number("--max-error-px", text));
  if (!(pixels > 0)) return fail("--max-error-px: expected a number > 0, got '{}'", text);
  return pixels;
}

/// One frame's surface, found from the last one's.
Result<Json> follow(LiveQuery& live, const Query& query, Progress& progress, Surface& surface) {
  constexpr int kStepsPerLook = 1024;
  const Stopwatch watch;
  live.set_query(query);
  for (int i = 1; live.step(); ++i)
    if (i % kStepsPerLook == 0 && progress.is_cancelled()) return cancelled_error();
  Json frame;
  frame["steps"] = live.standing().n_steps;
  frame["seconds"] = watch.seconds();
  frame["achieved_px"] = live.achieved_px();
  frame["nodes"] = live.standing().n_applied;
  frame["finest_share"] = live.finest_share();
  live.write(surface);
  frame["triangles"] = surface.triangles.size();
  return frame;
}

}  // namespace

void add_path_options(CLI::App& app, PathArguments& arguments) {
  const auto add = [&](const char* name, std::string& value, const char* type, const char* help) {
    app.add_option(name, value, help)->type_name(type)->group("Moving camera");
  };
  add("--camera-path", arguments.path, "PATH",
      "orbit, fly-in, jump, or a JSON file with an array of cameras");
  add("--frames", arguments.frames, "DIR",
      "Draw a frame for each camera, frame-0000.png and so on, to a new or empty directory; of a "
      "mesh of cells each is the picture with that --camera, its mesh refined from the last one's, "
      "and OUT.png without --camera the first");
  add("--max-error-px", arguments.max_error_px, "P",
      "Tolerance of these frames in pixels, by an estimate of distances (default of a volume's: "
      "1); of a picture of terrain, proven, by a model whose tolerances vary; of one of a mesh of "
      "cells built with --space-errors, by an estimate, with --camera, --camera-path or --view");
}

Result<void> check_path_and_frames(const PathArguments& arguments,
                                   const std::vector<std::string>& outputs) {
  if (arguments.path.empty() != arguments.frames.empty())
    return fail("{}: expected {} with it", arguments.path.empty() ? "--frames" : "--camera-path",
                arguments.path.empty() ? "--camera-path" : "--frames");
  if (arguments.frames.empty()) return {};
  const auto place_of = [](const std::filesystem::path& path) {
    std::error_code ignored;
    const std::filesystem::path place = std::filesystem::weakly_canonical(path, ignored);
    return place.has_filename() ? place : place.parent_path();
  };
  for (const std::string& output : outputs)
    if (place_of(output).parent_path() == place_of(arguments.frames))
      return fail("--frames: expected a directory for frames alone, got {}, which {} is in",
                  arguments.frames, output);
  return {};
}

Result<void> check_path(const PathArguments& arguments, const std::vector<std::string>& outputs,
                        const ExtractionArguments& extraction) {
  LODE_CHECK(check_path_and_frames(arguments, outputs));
  LODE_CHECK(parse_pixels(arguments.max_error_px));
  if (!arguments.is_wanted() && !arguments.max_error_px.empty())
    return fail("--max-error-px: expected --camera-path with it, terrain or a mesh of cells");
  if (!arguments.is_wanted()) return {};
  LODE_TRY(const ExtractOptions options, to_extract_options(extraction));
  if (options.isovalues.size() != 1)
    return fail("--camera-path: expected one --isovalue, got {}", options.isovalues.size());
  for (const auto& [name, is_set] : {std::pair{"--clip", !extraction.clip.empty()},
                                     {"--close-border", extraction.close_border},
                                     {"--min-component", !extraction.min_component.empty()},
                                     {"--style", extraction.style != "tetra"},
                                     {"--flip", extraction.flip}})
    if (is_set) return fail("{}: expected no --camera-path with it", name);
  return {};
}

Result<Json> draw_path(const PathJob& job, Session& session, OutputSet& outputs) {
  Progress& progress = session.progress();
  const Box3d bounds = job.input.info.volume.grid.world_bounds();
  const double aspect = static_cast<double>(job.picture.width) / job.picture.height;
  LODE_TRY(const auto cameras, camera_path(job.arguments.path, bounds, aspect));
  Query query;
  query.isovalues = job.extraction.isovalues;
  query.max_error = job.extraction.max_error;
  LODE_TRY(query.max_error_px, parse_pixels(job.arguments.max_error_px));
  const auto opened =
      open_live_query(job.input.dataset, {.normals = job.extraction.normals}, progress);
  if (!opened) return opened.error();
  RenderOptions picture = job.picture;
  Surface surface;
  Json frames = Json::array();
  for (const Camera& camera : cameras) {
    query.view = View{camera, picture.width, picture.height};
    LODE_CHECK(check_live_query(query, true));
    LODE_TRY(Json frame, follow(**opened, query, progress, surface));
    picture.camera = camera;
    LODE_TRY(const Image image, render_surface(surface, bounds, picture, progress));
    if (progress.is_cancelled()) return cancelled_error();
    const std::string path = job.folder.path_of(fmt::format("frame-{:04}.png", frames.size()));
    LODE_CHECK(write_png(image, path));
    outputs.add(path);
    progress.report("frames",
                    static_cast<double>(frames.size() + 1) / static_cast<double>(cameras.size()));
    frames.push_back(std::move(frame));
  }
  Json report;
  report["path"] = job.arguments.path;
  report["frames"] = std::move(frames);
  return report;
}

}  // namespace lode::cli
