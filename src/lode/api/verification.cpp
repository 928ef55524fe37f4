#include "lode/api/verification.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <utility>

#include "lode/models/diamond/attribute_check.h"
#include "lode/models/diamond/model_samples.h"
#include "lode/models/diamond/persist.h"
#include "lode/models/diamond/sample_check.h"

namespace lode {
namespace {

using diamond::as_size;
using diamond::Model;

/// The first way in which two grids differ, or nothing.
std::string difference_of(const VolumeInfo& ours, const VolumeInfo& theirs) {
  const auto differ = [](const char* what, const auto& a, const auto& b) {
    return fmt::format("{}: stored {}, original {}", what, fmt::join(a.v, " "),
                       fmt::join(b.v, " "));
  };
  if (ours.grid.spacing != theirs.grid.spacing)
    return differ("spacing", ours.grid.spacing, theirs.grid.spacing);
  if (ours.grid.origin != theirs.grid.origin)
    return differ("origin", ours.grid.origin, theirs.grid.origin);
  for (std::size_t i = 0; i < 3; ++i)
    if (ours.grid.direction.column(i) != theirs.grid.direction.column(i))
      return differ("direction", ours.grid.direction.column(i), theirs.grid.direction.column(i));
  if (ours.grid.frame != theirs.grid.frame)
    return fmt::format("frame: stored {}, original {}", name_of(ours.grid.frame),
                       name_of(theirs.grid.frame));
  if (ours.nodata != theirs.nodata)
    return fmt::format("nodata: stored {}, original {}",
                       ours.nodata ? fmt::format("{}", *ours.nodata) : "none",
                       theirs.nodata ? fmt::format("{}", *theirs.nodata) : "none");
  return {};
}

std::string lacks_memory(std::uint64_t least, const diamond::RebuildSettings& settings) {
  return fmt::format("not looked at: takes at least {} MB of memory, of {:.3g} MB",
                     least / 1'000'000 + 1, static_cast<double>(settings.memory_limit) / 1e6);
}

/// Samples that are not the original's.
struct Differences {
  std::uint64_t n = 0;
  std::string first;

  void compare(const Index3& p, double stored, double original) {
    if (stored == original || (!std::isfinite(stored) && !std::isfinite(original))) return;
    if (n++ == 0)
      first =
          fmt::format("{} instead of {} at sample {} {} {}", stored, original, p[0], p[1], p[2]);
  }
  void append(const Differences& later) {
    if (n == 0) first = later.first;
    n += later.n;
  }
};

Result<void> check_same_grid(const VolumeInfo& ours, const VolumeInfo& theirs,
                             VerifyReport& report) {
  const Index3& dims = ours.grid.dims;
  if (theirs.grid.dims != dims)
    return fail("expected an original of {} x {} x {} samples, got {} x {} x {}", dims[0], dims[1],
                dims[2], theirs.grid.dims[0], theirs.grid.dims[1], theirs.grid.dims[2]);
  const std::string difference = difference_of(ours, theirs);
  report.add("grid and nodata equal the original's", 1, difference.empty() ? 0 : 1, difference);
  return {};
}

template <int D>
Result<void> check_same_samples(const Model<D>& model, VolumeSource& original, Threads threads,
                                Progress& progress, VerifyReport& report) {
  const RegularGrid& grid = model.info.grid;
  LODE_CHECK(check_same_grid(model.info, original.info(), report));
  LODE_TRY(const Volume volume, read_all(original));
  const diamond::VolumeSamples theirs(volume);
  const diamond::ModelSamples<D> ours(model);
  std::vector<Differences> by_slice(static_cast<std::size_t>(grid.dims[2]));
  std::atomic<std::int32_t> n_done{0};
  parallel_for(by_slice.size(), threads, 1, [&](std::size_t z, int) {
    Index3 p{{0, 0, static_cast<std::int32_t>(z)}};
    for (p[1] = 0; p[1] < grid.dims[1] && !progress.is_cancelled(); ++p[1])
      for (p[0] = 0; p[0] < grid.dims[0]; ++p[0])
        by_slice[z].compare(p, ours.sample(p), theirs.sample(p));
    progress.report("comparing samples", static_cast<double>(++n_done) / grid.dims[2]);
  });
  if (progress.is_cancelled()) return cancelled_error();
  Differences all;
  for (const Differences& differences : by_slice) all.append(differences);
  report.add("samples equal the original's", static_cast<std::uint64_t>(grid.n_samples()), all.n,
             all.n == 0 ? "" : fmt::format("{} differ; first: {}", all.n, all.first));
  return {};
}

void add_finding(VerifyReport& report, std::string name, const diamond::AttributeFinding& finding) {
  report.add(
      std::move(name), finding.n_checked, finding.n_wrong,
      finding.n_wrong == 0 ? "" : fmt::format("{} wrong; {}", finding.n_wrong, finding.worst));
}

}  // namespace

template <int D>
Result<void> verify_attributes(const store::Reader& reader,
                               const diamond::RebuildSettings& settings, Progress& progress,
                               VerifyReport& report) {
  LODE_TRY(const diamond::Metadata metadata, diamond::read_metadata(reader));
  const std::uint64_t least = diamond::least_rebuild_bytes<D>(metadata.info);
  if (least > settings.memory_limit) {
    report.skip("blocks, metadata and samples agree", lacks_memory(least, settings));
    return {};
  }
  LODE_TRY(const auto findings, diamond::rebuild_check<D>(reader, settings, progress));
  // Where they do not that has ended the check.
  report.add("metadata and samples agree", findings.n_blocks, 0,
             "range, holes, largest errors, samples beyond the data, number of blocks");
  add_finding(report, "errors and ranges are the samples'", findings.nodes);
  if (findings.worlds.n_checked > 0)
    add_finding(report, "world errors are the samples'", findings.worlds);
  return {};
}

template Result<void> verify_attributes<2>(const store::Reader&, const diamond::RebuildSettings&,
                                           Progress&, VerifyReport&);
template Result<void> verify_attributes<3>(const store::Reader&, const diamond::RebuildSettings&,
                                           Progress&, VerifyReport&);

template <int D>
Result<VerifyReport> verify_model_against(const Model<D>& model, VolumeSource& original,
                                          Threads threads, Progress& progress) {
  VerifyReport report;
  LODE_CHECK(check_same_samples<D>(model, original, threads, progress, report));
  LODE_TRY(const auto attributes, diamond::check_attributes<D>(model, threads, progress));
  add_finding(report, "own errors <= stored errors", attributes.own_errors);
  add_finding(report, "own ranges inside stored ranges", attributes.own_ranges);
  add_finding(report, "stored values nested", attributes.nesting);
  add_finding(report, "stored values no wider than rounding makes them", attributes.tightness);
  if (attributes.worlds.n_checked > 0)
    add_finding(report, "stored world errors as defined", attributes.worlds);
  return report;
}

template <int D>
Result<VerifyReport> verify_samples_against(const store::Reader& reader, VolumeSource& original,
                                            const diamond::RebuildSettings& settings,
                                            Progress& progress) {
  VerifyReport report;
  LODE_TRY(const diamond::Metadata metadata, diamond::read_metadata(reader));
  LODE_CHECK(check_same_grid(metadata.info, original.info(), report));
  const std::uint64_t least = original.memory_bytes() + diamond::least_comparison_bytes<D>(
                                                            metadata.info, original.info().type);
  if (least > settings.memory_limit) {
    report.skip("samples equal the original's", lacks_memory(least, settings));
    return report;
  }
  diamond::RebuildSettings left = settings;
  left.memory_limit -= original.memory_bytes();
  LODE_TRY(const auto finding, diamond::compare_samples<D>(reader, original, left, progress));
  report.add(
      "samples equal the original's", finding.n_checked, finding.n_wrong,
      finding.n_wrong == 0 ? "" : fmt::format("{} differ; {}", finding.n_wrong, finding.worst));
  return report;
}

template Result<VerifyReport> verify_samples_against<2>(const store::Reader&, VolumeSource&,
                                                        const diamond::RebuildSettings&, Progress&);
template Result<VerifyReport> verify_samples_against<3>(const store::Reader&, VolumeSource&,
                                                        const diamond::RebuildSettings&, Progress&);

template Result<VerifyReport> verify_model_against<2>(const Model<2>&, VolumeSource&, Threads,
                                                      Progress&);
template Result<VerifyReport> verify_model_against<3>(const Model<3>&, VolumeSource&, Threads,
                                                      Progress&);

}  // namespace lode
