#include "terrain_clip.h"

#include <fmt/format.h>

#include "terrain_focus_options.h"

namespace lode::cli {

Result<std::optional<PlaceBox>> to_terrain_clip(const std::string& clip,
                                                const std::string& output) {
  if (clip.empty()) return std::optional<PlaceBox>();
  if (is_geotiff_path(output))
    return fail("--clip: expected a surface to write with it, got the raster {}", output);
  LODE_TRY(const PlaceBox box, parse_place_box("--clip", clip));
  return std::optional(box);
}

Json clip_json(const std::optional<TerrainClip>& clip) {
  if (!clip) return nullptr;
  return {{"box", {clip->box.lower[0], clip->box.upper[0], clip->box.lower[1], clip->box.upper[1]}},
          {"triangles", clip->n_kept},
          {"of_triangles", clip->n_triangles}};
}

void add_clip_row(const std::optional<TerrainClip>& clip, Table& table) {
  if (!clip) return;
  table.add({"clip", fmt::format("{} of {} triangles meet it, and are written whole",
                                 format_count(clip->n_kept), format_count(clip->n_triangles))});
}

}  // namespace lode::cli
