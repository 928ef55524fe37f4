#include "progressive_options.h"

#include <utility>

namespace lode::cli {

void add_progressive_option(CLI::App& app, ProgressiveArguments& arguments, const char* help) {
  app.add_option("--progressive", arguments.directory, help)->type_name("DIR")->group("Steps");
}

Result<void> check_progressive(const ProgressiveArguments& arguments,
                               const ExtractionArguments& extraction) {
  if (!arguments.is_wanted()) {
    if (arguments.frames_per_step.empty()) return {};
    return fail("--frames-per-step: expected --progressive with it");
  }
  LODE_TRY(const ExtractOptions options, to_extract_options(extraction));
  if (options.isovalues.size() != 1)
    return fail("--progressive: expected one --isovalue, got {}", options.isovalues.size());
  if (options.style != SurfaceStyle::tetra)
    return fail("--style cubes: expected no --progressive with it, whose steps are the field's");
  for (const auto& [name, is_set] : {std::pair{"--close-border", extraction.close_border},
                                     {"--keep-topology", !extraction.keep_topology.empty()},
                                     {"--min-component", !extraction.min_component.empty()}})
    if (is_set)
      return fail("{}: expected no --progressive with it: it would change from step to step", name);
  return {};
}

Json step_json(const ProgressiveStep& step, const Surface& surface) {
  Json json;
  json["max_error"] = step.max_error;
  json["achieved_error"] = step.achieved_error;
  if (surface.lines.empty())
    json["triangles"] = surface.triangles.size();
  else
    json["lines"] = surface.lines.size();
  json["vertices"] = surface.positions.size();
  json["new_nodes"] = step.new_nodes;
  return json;
}

}  // namespace lode::cli
