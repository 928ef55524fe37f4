#include <fmt/format.h>

#include <memory>

#include "command.h"
#include "describe.h"
#include "extraction_options.h"
#include "input.h"
#include "lode/api/creased_caps.h"
#include "lode/api/suggested_isovalue.h"
#include "outputs.h"
#include "parse.h"
#include "render_path.h"
#include "render_progressive.h"
#include "render_terrain.h"
#include "render_tetra.h"
#include "stopwatch.h"
#include "tetra_input.h"
#include "tetra_picture.h"
#include "text.h"
#include "tolerance.h"
#include "vtk_import.h"

namespace lode::cli {
namespace {

constexpr std::int64_t kMaxSide = 16384;
constexpr std::int64_t kMaxSamples = 4096;

struct RenderArguments {
  std::string input;
  std::string output;
  std::string size = "1200x900";
  std::string camera;
  std::string save_camera;
  std::string color;
  std::string background;
  std::string samples;
  ExtractionArguments extraction;
  ProgressiveArguments progressive;
  PathArguments path;
  ReadingArguments reading;
  TetraPictureArguments tetra;
  TerrainPictureArguments terrain;

  [[nodiscard]] std::vector<std::string> inputs() const {
    return camera.empty() ? std::vector{input} : std::vector{input, camera};
  }
  [[nodiscard]] std::vector<std::string> outputs() const {
    return save_camera.empty() ? std::vector{output} : std::vector{output, save_camera};
  }
};

Result<Color> parse_color_option(const char* option, const std::string& text) {
  auto color = parse_color(text);
  if (!color) return fail("{}: {}", option, color.error().message);
  return color;
}

/// One colour, or two separated by a comma: the top and the bottom of a gradient.
Result<Background> parse_background(const std::string& text) {
  const std::size_t comma = text.find(',');
  LODE_TRY(const Color top, parse_color_option("--background", text.substr(0, comma)));
  if (comma == std::string::npos) return Background{top, top};
  LODE_TRY(const Color bottom, parse_color_option("--background", text.substr(comma + 1)));
  return Background{top, bottom};
}

/// Everything but the camera, which is in a file.
Result<RenderOptions> to_render_options(const RenderArguments& arguments) {
  RenderOptions options;
  LODE_TRY(const auto size, parse_dims("--size", arguments.size, kMaxSide));
  if (size.size() != 2)
    return fail("--size: expected width and height as 1200x900, got '{}'", arguments.size);
  options.width = static_cast<int>(size[0]);
  options.height = static_cast<int>(size[1]);
  if (!arguments.color.empty()) {
    LODE_TRY(options.color, parse_color_option("--color", arguments.color));
    if (options.color->a < 255)
      return fail("--color: expected an opaque colour, as surfaces are, got '{}'", arguments.color);
  }
  if (!arguments.background.empty()) {
    LODE_TRY(options.background, parse_background(arguments.background));
  }
  if (!arguments.samples.empty()) {
    LODE_TRY(const auto n, parse_integer("--samples", arguments.samples, 1, kMaxSamples));
    options.samples_per_pixel = static_cast<int>(n);
  }
  return options;
}

TetraPictureJob tetra_job(const RenderArguments& arguments, const RenderOptions& options) {
  return {arguments.input,          arguments.output,     arguments.camera,
          arguments.save_camera,    arguments.extraction, arguments.reading,
          arguments.tetra,          arguments.path,       options,
          arguments.samples.empty()};
}

TerrainPictureJob terrain_job(const RenderArguments& arguments, const RenderOptions& options) {
  return {arguments.input,
          arguments.output,
          arguments.camera,
          arguments.save_camera,
          arguments.extraction.max_error,
          arguments.tetra.query.max_cells,
          arguments.path.max_error_px,
          arguments.reading,
          arguments.terrain,
          options};
}

Result<void> check_tetra_render(const RenderArguments& arguments) {
  if (arguments.progressive.is_wanted())
    return fail("{}: expected no --progressive with a mesh of cells", arguments.input);
  LODE_TRY(const RenderOptions options, to_render_options(arguments));
  return check_tetra_picture(tetra_job(arguments, options));
}

Result<void> check_render(const RenderArguments& arguments, const CLI::App& app) {
  if (holds_terrain(arguments.input)) {
    LODE_TRY(const RenderOptions options, to_render_options(arguments));
    return check_terrain_picture(terrain_job(arguments, options), app);
  }
  LODE_CHECK(check_no_terrain_picture(arguments.terrain, arguments.input));
  if (holds_cells(arguments.input)) return check_tetra_render(arguments);
  if (!arguments.tetra.is_empty())
    return fail(
        "{}: expected a mesh of cells with --opacity, --section, --boundary, --wireframe, "
        "--points, "
        "--warp, a focus, --threshold, --region, --max-cells or --deadline-ms, got a volume",
        arguments.input);
  LODE_TRY(const ExtractOptions extraction, to_extract_options(arguments.extraction));
  if (extraction.isovalues.empty()) LODE_CHECK(check_is_volume(arguments.input, arguments.reading));
  LODE_CHECK(check_extension(arguments.output, ".png"));
  LODE_CHECK(check_reading_options(arguments.reading, arguments.input));
  if (auto options = to_render_options(arguments); !options) return options.error();
  LODE_CHECK(check_progressive(arguments.progressive, arguments.extraction));
  LODE_CHECK(to_frames_per_step(arguments.progressive));
  LODE_CHECK(check_path(arguments.path, arguments.outputs(), arguments.extraction));
  return check_paths_differ(arguments.inputs(), arguments.outputs());
}

struct Rendering {
  ExtractReport extraction;
  double render_seconds = 0;
  Camera camera;
  Json frames{};  ///< With --progressive.
  Json path{};    ///< With --camera-path.
};

Json rendering_json(const RenderArguments& arguments, const ExtractOptions& options,
                    const Input& input, const Rendering& rendering) {
  const ExtractReport& report = rendering.extraction;
  Json json;
  json["command"] = "render";
  json["input"] = arguments.input;
  json["outputs"] = arguments.outputs();
  json["built_in_memory"] = input.was_built;
  add_extraction(json, options, report);
  add_units(json, input.info.volume.units);
  json["components_dropped"] = report.components_dropped;
  json["triangles_dropped"] = report.triangles_dropped;
  json["size"] = arguments.size;
  json["camera"] = camera_json(rendering.camera);
  if (!rendering.frames.is_null()) json["progressive"] = rendering.frames;
  if (!rendering.path.is_null()) json["camera_path"] = rendering.path;
  Json& seconds = json["seconds"];
  seconds["total"] = report.seconds.total + rendering.render_seconds;
  seconds["open"] = input.open_seconds;
  seconds["extract"] = report.seconds.total;
  seconds["render"] = rendering.render_seconds;
  return json;
}

Outcome report_render(const RenderArguments& arguments, const ExtractOptions& options,
                      const Input& input, const Rendering& rendering,
                      const std::vector<std::string>& warnings) {
  const ExtractReport& report = rendering.extraction;
  Outcome outcome;
  outcome.json = rendering_json(arguments, options, input, rendering);
  outcome.json["warnings"] = warnings;
  Table table;
  add_isovalues(options.isovalues, table);
  table.add({"max error", describe_tolerance(options, report.max_error)});
  table.add({"achieved error", format_number(report.achieved_error)});
  add_units(table, input.info.volume.units);
  if (report.topology) table.add({"topology", describe_topology(report)});
  add_style(options, report, input.info.n_holes > 0, table);
  const bool is_lines = input.info.model == "diamond2d";
  table.add(
      {is_lines ? "lines" : "triangles", format_count(is_lines ? report.lines : report.triangles)});
  add_dropped(options, report.components_dropped, report.triangles_dropped, is_lines, table);
  table.add({"size", arguments.size + " pixels"});
  table.add({input.was_built ? "read and build" : "open", format_seconds(input.open_seconds)});
  table.add({"extract", format_seconds(report.seconds.total)});
  table.add({"render", format_seconds(rendering.render_seconds)});
  if (!rendering.frames.is_null())
    table.add({"frames", fmt::format("{} in {}", rendering.frames["frames"].get<int>(),
                                     arguments.progressive.directory)});
  if (!rendering.path.is_null())
    table.add({"frames",
               fmt::format("{} in {}", rendering.path["frames"].size(), arguments.path.frames)});
  for (const std::string& path : arguments.outputs()) table.add({"output", path});
  outcome.text = table.to_string();
  return outcome;
}

/// Frames the surface where no camera is given.
void use_camera_of(const Surface& surface, const VolumeInfo& volume, RenderOptions& options) {
  options.axes = viewing_axes(volume.grid.frame);
  if (!options.camera)
    options.camera = framing_camera(surface, volume.grid.world_bounds(), options);
}

/// Draws and writes; the camera that was used comes back in `rendering`.
Result<void> draw(const RenderArguments& arguments, const Surface& surface,
                  const VolumeInfo& volume, RenderOptions& options, Session& session,
                  Rendering& rendering) {
  const Stopwatch watch;
  const Box3d bounds = volume.grid.world_bounds();
  use_camera_of(surface, volume, options);
  rendering.camera = *options.camera;
  LODE_TRY(const Image image, render_surface(surface, bounds, options, session.progress()));
  if (session.progress().is_cancelled()) return cancelled_error();
  OutputSet outputs(arguments.outputs());
  LODE_CHECK(write_png(image, arguments.output));
  outputs.add(arguments.output);
  if (!arguments.save_camera.empty())
    LODE_CHECK(write_camera(rendering.camera, arguments.save_camera));
  outputs.keep();
  rendering.render_seconds = watch.seconds();
  return {};
}

Result<Outcome> run_render(const RenderArguments& arguments, Session& session) {
  LODE_TRY(RenderOptions options, to_render_options(arguments));
  if (holds_terrain(arguments.input))
    return run_terrain_picture(terrain_job(arguments, options), session);
  if (holds_cells(arguments.input))
    return run_tetra_picture(tetra_job(arguments, options), session);
  LODE_TRY(ExtractOptions extraction, to_extract_options(arguments.extraction));
  options.threads = extraction.threads = session.threads();
  if (!arguments.camera.empty()) {
    LODE_TRY(options.camera, read_camera(arguments.camera));
  }
  for (const std::string& path : arguments.outputs()) LODE_CHECK(check_writable(path));
  LODE_TRY(OutputFolder folder, OutputFolder::make(arguments.progressive.directory));
  LODE_TRY(OutputFolder path_folder, OutputFolder::make(arguments.path.frames));
  LODE_TRY(const Input input, load_input(session, arguments.input, arguments.reading));
  set_share(arguments.extraction.max_error, input.info.range_min, input.info.range_max,
            extraction.max_error);
  set_share(arguments.extraction.keep_topology, input.info.range_min, input.info.range_max,
            extraction.keep_topology);
  if (extraction.isovalues.empty()) {
    LODE_TRY(const auto isovalue, suggest_isovalue(input.dataset, session.progress()));
    if (!isovalue)
      return fail("{}: expected --isovalue, or values that one parts in two, got neither",
                  arguments.input);
    extraction.isovalues = {*isovalue};
    session.note(
        fmt::format("--isovalue {}, as none was given: it parts the values best", *isovalue));
  }
  Rendering rendering;
  Surface surface;
  LODE_TRY(rendering.extraction, input.dataset.extract(extraction, surface, session.progress()));
  warn_of_open(session, rendering.extraction);
  warn_of_persistence(session, rendering.extraction, extraction, input.info);
  warn_of_unmet(session, rendering.extraction, extraction, input.info);
  if (extraction.border == Border::closed)
    crease_caps(input.info.volume.grid, options.threads, surface);
  OutputSet frames({});
  if (arguments.progressive.is_wanted()) {
    LODE_TRY(const int n, to_frames_per_step(arguments.progressive));
    use_camera_of(surface, input.info.volume, options);
    LODE_TRY(rendering.frames,
             draw_frames({folder, n, extraction, options, input}, session, frames));
  }
  if (arguments.path.is_wanted()) {
    options.axes = viewing_axes(input.info.volume.grid.frame);
    LODE_TRY(rendering.path,
             draw_path({arguments.path, path_folder, extraction, options, input}, session, frames));
  }
  LODE_CHECK(draw(arguments, surface, input.info.volume, options, session, rendering));
  frames.keep();
  folder.keep();
  path_folder.keep();
  return report_render(arguments, extraction, input, rendering, session.warnings());
}

void add_picture_options(CLI::App& app, RenderArguments& arguments) {
  const auto add = [&app](const char* name, std::string& value, const char* type,
                          const char* help) {
    app.add_option(name, value, help)->type_name(type)->group("Picture");
  };
  add("--size", arguments.size, "WxH", "Pixels (default: 1200x900)");
  add("--camera", arguments.camera, "FILE", "Look through the camera in a JSON file");
  add("--save-camera", arguments.save_camera, "FILE", "Write the camera that was used");
  add("--color", arguments.color, "C", "Colour of the surface: a name or #rrggbb");
  add("--background", arguments.background, "C[,C]", "Colour, or top and bottom of a gradient");
  add("--samples", arguments.samples, "N", "Rays per pixel; more is smoother and slower");
}

}  // namespace

Json camera_json(const Camera& camera) {
  const auto vector = [](const Vec3d& v) { return Json::array({v[0], v[1], v[2]}); };
  Json json;
  json["eye"] = vector(camera.eye);
  json["target"] = vector(camera.target);
  json["up"] = vector(camera.up);
  json["field_of_view_deg"] = camera.field_of_view_deg;
  return json;
}

/// Of volumes, meshes and terrain.
constexpr HelpFooter kRenderFooter{{{
    {"",
     "  lode render scan.lode bone.png --isovalue 1200 --max-error 10 --size 1600x1200\n"
     "  lode render scan.lode first.png --isovalue 1200 --camera-path orbit --frames film\n"},
    {"",
     "  lode render wing.vtu wing.png --opacity viridis-smoke --isovalue 2.1 --max-cells 200000\n"
     "  lode render wing.lode tip.png --boundary --camera tip.json --threshold 2:3\n"
     "  lode render wing.lode first.png --isovalue 2.1 --camera-path orbit --frames film\n"},
    {"", "  lode render dem.tif map.png --top --contours 100\n"},
}}};

Command add_render_command(CLI::App& program) {
  auto arguments = std::make_shared<RenderArguments>();
  CLI::App* app = program.add_subcommand(
      "render", "Draw isosurfaces, the volume of a mesh, or terrain to a PNG picture");
  app->add_option("file", arguments->input,
                  ".lode file, a volume or mesh to build in memory, or terrain")
      ->type_name("FILE")
      ->required();
  app->add_option("output", arguments->output, "Picture to write")
      ->type_name("OUT.png")
      ->required();
  add_picture_options(*app, *arguments);
  add_extraction_options(*app, arguments->extraction);
  add_frame_options(*app, arguments->progressive);
  add_path_options(*app, arguments->path);
  add_tetra_picture_options(*app, arguments->tetra);
  add_terrain_picture_options(*app, arguments->terrain);
  add_reading_options(*app, arguments->reading);
  return {app, [arguments, app] { return check_render(*arguments, *app); },
          [arguments](Session& session) { return run_render(*arguments, session); }, kRenderFooter};
}

}  // namespace lode::cli
