#include "lode/api/persistence_verification.h"

#include <fmt/format.h>

#include <string>

#include "lode/mappers/surface_topology.h"
#include "lode/models/diamond/persistent_regions.h"

namespace lode {

Result<void> add_persistent(const diamond::FieldSamples& samples, bool has_holes,
                            const Surface& surface, const ExtractOptions& options,
                            Progress& progress, VerifyReport& report) {
  const double persistence = *options.keep_topology;
  const std::string name = fmt::format("at least as many regions as persist by {}", persistence);
  if (has_holes || options.border == Border::closed) {
    report.skip(name,
                has_holes ? "not counted between holes" : "not counted where caps join pieces");
    return {};
  }
  std::uint64_t n_persistent = 0;
  for (const double isovalue : options.isovalues) {
    LODE_TRY(const auto found, diamond::count_persistent_regions(samples, isovalue, persistence,
                                                                 options.threads, progress));
    n_persistent += found.inside + found.outside;
  }
  const std::uint64_t n_apart =
      check_topology(surface, {.threads = options.threads}).components.size() +
      options.isovalues.size();
  report.add(name, n_persistent, n_persistent > n_apart ? n_persistent - n_apart : 0,
             fmt::format("{} persist, the surface parts {}", n_persistent, n_apart));
  return {};
}

}  // namespace lode
