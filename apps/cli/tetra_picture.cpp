#include "tetra_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tetra_query_options.h"
#include "text.h"

namespace lode::cli {
namespace {

constexpr double kBoundaryOpacity = 0.12;
constexpr double kWireWidth = 1;
constexpr int kVolumeSamples = 4;  // A volume alone has soft edges but for its border.

/// What is seen through the camera, where that is what the mesh is asked for.
std::optional<View> own_view(const TetraPictureJob& job, const std::optional<Camera>& camera) {
  if (!camera || !job.has_own_view()) return std::nullopt;
  return View{*camera, job.options.width, job.options.height};
}

/// What of the mesh is wanted for what is shown.
Result<TetraMeshOptions> to_picture_query(const TetraPictureJob& job,
                                          const std::optional<Camera>& camera,
                                          const MeshPictureOptions& picture) {
  LODE_TRY(TetraMeshOptions options,
           to_tetra_query(job.query(), job.extraction, "mesh of cells", own_view(job, camera)));
  Query shown = query_of(picture);
  options.query.isovalues = std::move(shown.isovalues);
  options.query.opacity = std::move(shown.opacity);
  options.query.sections = std::move(shown.sections);
  LODE_CHECK(check_outside(options.query));
  return options;
}

/// But for what the transfer function is, which may need the mesh.
Result<MeshPictureOptions> to_picture(const TetraPictureJob& job) {
  MeshPictureOptions options;
  LODE_TRY(const ExtractOptions extraction, to_extract_options(job.extraction));
  options.render = job.options;
  options.has_boundary = job.is_default() || job.picture.boundary == "field";
  if (job.is_default_samples && extraction.isovalues.empty() && !options.has_boundary &&
      job.picture.query.sections.empty() && !job.picture.has_wireframe && !job.picture.has_points)
    options.render.samples_per_pixel = kVolumeSamples;
  options.isovalues = extraction.isovalues;
  options.has_wireframe = job.picture.has_wireframe;
  options.has_points = job.picture.has_points;
  options.boundary_opacity = job.picture.boundary == "film" ? kBoundaryOpacity : 0;
  if (options.has_wireframe) options.render.line_width_px = kWireWidth;
  LODE_TRY(options.sections, to_planes(job.picture.query));
  if (!job.picture.query.opacity.empty()) options.opacity = TransferFunction{{TransferKnot{}}};
  return options;
}

/// The field, and its time where it has one.
std::string title_of(const TetraFieldInfo& field) {
  return field.name + (field.time ? fmt::format(" at {}", format_number(*field.time)) : "");
}
/// As lists of fields have it.
std::string timed_name(const TetraFieldInfo& field) {
  return field.name + (field.time ? fmt::format(" at {}", *field.time) : "");
}

/// Where among further fields the one is whose colours are shown; none: the field's own are.
Result<std::optional<std::size_t>> find_colors(const TetraPictureJob& job,
                                               const TetraInput& input) {
  const std::string& name = job.picture.color_by;
  if (name.empty()) return std::optional<std::size_t>();
  const std::vector<TetraFieldInfo>& fields = input.dataset.describe().fields;
  const auto is_meant = [&](std::size_t place) {
    const TetraFieldInfo& field = fields[place];
    const std::string scalar = numbered_component(name);
    return field.name == scalar || field.name == name || timed_name(field) == scalar;
  };
  const auto& along = input.fields.along;
  if (const auto at = std::ranges::find_if(along, is_meant); at != along.end())
    return std::optional(static_cast<std::size_t>(at - along.begin()));
  return fail("--color-by: expected one scalar of another field than {}, got {}",
              input.field().name, name);
}

}  // namespace

Result<TetraPicturePlan> check_picture_plan(const TetraPictureJob& job,
                                            const std::optional<Camera>& camera) {
  TetraPicturePlan plan;
  LODE_TRY(plan.shown, to_picture(job));
  LODE_TRY(plan.wanted, to_picture_query(job, camera, plan.shown));
  return plan;
}

Result<TetraPicturePlan> plan_picture(const TetraPictureJob& job, const TetraInput& input,
                                      const std::optional<Camera>& camera, Session& session) {
  const TetraInfo& info = input.dataset.describe();
  TetraPicturePlan plan;
  LODE_TRY(plan.shown, to_picture(job));
  LODE_TRY(plan.shown.color_attribute, find_colors(job, input));
  const TetraFieldInfo& colored = plan.shown.color_attribute
                                      ? info.fields[input.fields.along[*plan.shown.color_attribute]]
                                      : input.field();
  plan.shown.colors = {colored.range_min, colored.range_max};
  if (!job.picture.color_range.empty()) {
    LODE_TRY(plan.shown.colors, parse_range("--color-range", job.picture.color_range));
  }
  if (job.picture.legend != "off") plan.shown.legend = title_of(colored);
  if (!job.picture.query.opacity.empty()) {
    const Range range = job.picture.color_by.empty()
                            ? plan.shown.colors
                            : Range{input.field().range_min, input.field().range_max};
    LODE_TRY(plan.shown.opacity,
             to_transfer_function(job.picture.query.opacity, info.bounds, range));
    if (range.low == range.high)
      session.warn(fmt::format("the field has one value, {}: its volume has one colour, or none",
                               format_number(range.low)));
  }
  LODE_TRY(plan.wanted, to_picture_query(job, camera, plan.shown));
  set_shares(job.extraction, job.picture.query, input.field(), plan.wanted.query);
  plan.shown.render.threads = plan.wanted.threads = session.threads();
  LODE_TRY(plan.wanted.regions, wanted_regions(job.input, info, job.picture.query));
  plan.wanted.fields = input.fields;
  return plan;
}

Result<TetraPicture> draw_picture(const TetraPictureJob& job, const TetraInput& input,
                                  const TetraPicturePlan& plan, const std::optional<Camera>& camera,
                                  TetraSession& questions, Session& session) {
  TetraMeshOptions wanted = plan.wanted;
  if (const auto view = own_view(job, camera)) wanted.query.view = view;
  MeshPictureOptions shown = plan.shown;
  shown.render.camera = camera;
  TetraPicture made;
  const auto warn = [&made](std::string message) {
    if (!message.empty()) made.warnings.push_back(std::move(message));
  };
  SimplexMesh mesh;
  LODE_TRY(made.mesh, questions.extract_mesh(wanted, mesh, session.progress()));
  warn(budget_warning(made.mesh));
  if (mesh.is_empty())
    warn(wanted.threshold ? "the picture is empty: no cell of the cut lies in the threshold"
                          : "the picture is empty: the mesh has no cell");
  LODE_TRY(made.warped, apply_warp(job.picture.query.warp, input, made.mesh.largest_error,
                                   session.threads(), mesh));
  if (made.warped) warn(inverted_warning(made.warped->n_inverted));
  LODE_TRY(made.image, draw_mesh(mesh, shown, made.picture, session.progress()));
  if (!made.picture.legend_fault.empty())
    warn(fmt::format("there is no legend: {}", made.picture.legend_fault));
  for (const double isovalue : made.picture.unmet)
    warn(fmt::format("no surface at isovalue {}: it meets no cell", isovalue));
  return made;
}

}  // namespace lode::cli
