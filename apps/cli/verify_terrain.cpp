#include "verify_terrain.h"

namespace lode::cli {

Result<void> check_terrain_verify(const TerrainVerifyJob& job, const CLI::App& app) {
  LODE_CHECK(check_only_terrain(app, job.input, {"--surface", "--max-error"}));
  if (job.surface.empty())
    return fail("{}: expected --surface FILE to hold against this raster, got none", job.input);
  LODE_CHECK(check_surface_path(job.surface));
  if (job.max_error.empty())
    return fail("--surface: expected the --max-error it was extracted with, got none");
  if (auto max_error = to_max_error(job.max_error); !max_error) return max_error.error();
  if (auto options = to_height_options(job.terrain, job.reading); !options) return options.error();
  return {};
}

Result<VerifyReport> verify_terrain_surface(const TerrainVerifyJob& job, Session& session) {
  LODE_TRY(const HeightReadOptions reading, to_height_options(job.terrain, job.reading));
  LODE_TRY(const std::optional<double> max_error, to_max_error(job.max_error));
  LODE_TRY(const HeightRaster raster, read_heights(job.input, reading, session.progress()));
  LODE_TRY(const Surface surface, read_surface(job.surface));
  return verify_terrain(raster.grid, surface, max_error.value_or(0), session.threads(),
                        session.progress());
}

}  // namespace lode::cli
