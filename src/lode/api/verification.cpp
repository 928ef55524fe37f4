#include "lode/api/verification.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <utility>

#include "lode/models/diamond/attribute_check.h"
#include "lode/models/diamond/build.h"
#include "lode/models/diamond/model_samples.h"
#include "lode/models/diamond/persist.h"

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

template <int D>
Result<void> check_same_samples(const Model<D>& model, VolumeSource& original, Threads threads,
                                Progress& progress, VerifyReport& report) {
  const RegularGrid& grid = model.info.grid;
  if (original.info().grid.dims != grid.dims)
    return fail("expected an original of {} x {} x {} samples, got {} x {} x {}", grid.dims[0],
                grid.dims[1], grid.dims[2], original.info().grid.dims[0],
                original.info().grid.dims[1], original.info().grid.dims[2]);
  const std::string difference = difference_of(model.info, original.info());
  report.add("grid and nodata equal the original's", 1, difference.empty() ? 0 : 1, difference);
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

/// Of a level's nodes those whose attributes are not what they should be, by what is_equal(its
/// place among these) says; describe(place): what is wrong.
template <int D, typename IsEqual, typename Describe>
void compare_nodes(const diamond::Shape<D>& shape, int level, const IsEqual& is_equal,
                   const Describe& describe, diamond::AttributeFinding& finding) {
  const diamond::Index<D> dims = shape.grid_dims(level);
  for (std::size_t at = 0; at < diamond::n_points<D>(dims); ++at) {
    const diamond::Index<D> q = diamond::point_of<D>(dims, at);
    if (std::ranges::none_of(q.v, [](std::int32_t x) { return (x & 1) != 0; })) continue;
    ++finding.n_checked;
    if (is_equal(at)) continue;
    if (finding.n_wrong++ == 0)
      finding.worst = fmt::format("first: level {}, node {} of its grid: {}", level,
                                  fmt::join(q.v, " "), describe(at));
  }
}

template <int D>
void compare_levels(const Model<D>& found, const std::vector<diamond::NodeLevel>& stored,
                    diamond::AttributeFinding& finding) {
  for (std::size_t l = 1; l < stored.size(); ++l) {  // those of level 0 are not stored
    const diamond::NodeLevel& ours = found.levels[l];
    const diamond::NodeLevel& theirs = stored[l];
    compare_nodes<D>(
        found.shape, static_cast<int>(l),
        [&](std::size_t at) {
          return ours.error[at] == theirs.error[at] && ours.low[at] == theirs.low[at] &&
                 ours.high[at] == theirs.high[at];
        },
        [&](std::size_t at) {
          return fmt::format("error {}, range {} to {}; of the samples {}, {} to {}",
                             diamond::decode_error(theirs.error[at]), theirs.low[at],
                             theirs.high[at], diamond::decode_error(ours.error[at]), ours.low[at],
                             ours.high[at]);
        },
        finding);
  }
}

}  // namespace

template <int D>
Result<void> verify_attributes(const store::Reader& reader, Threads threads, Progress& progress,
                               VerifyReport& report) {
  LODE_TRY(Model<D> model, diamond::load<D>(reader, threads, progress));
  const std::vector<diamond::NodeLevel> stored = std::move(model.levels);
  const diamond::WorldErrors worlds = std::move(model.worlds);
  LODE_CHECK(diamond::build_attributes<D>(model, !worlds.empty(), threads, progress));
  diamond::AttributeFinding levels;
  compare_levels<D>(model, stored, levels);
  add_finding(report, "errors and ranges are the samples'", levels);
  if (worlds.empty()) return {};
  diamond::AttributeFinding finding;
  for (std::size_t l = 1; l < worlds.size(); ++l)
    compare_nodes<D>(
        model.shape, static_cast<int>(l),
        [&](std::size_t at) { return worlds[l][at] == model.worlds[l][at]; },
        [&](std::size_t at) {
          return fmt::format("{} edges; of the samples {}", diamond::decode_world(worlds[l][at]),
                             diamond::decode_world(model.worlds[l][at]));
        },
        finding);
  add_finding(report, "world errors are the samples'", finding);
  return {};
}

template Result<void> verify_attributes<2>(const store::Reader&, Threads, Progress&, VerifyReport&);
template Result<void> verify_attributes<3>(const store::Reader&, Threads, Progress&, VerifyReport&);

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

template Result<VerifyReport> verify_model_against<2>(const Model<2>&, VolumeSource&, Threads,
                                                      Progress&);
template Result<VerifyReport> verify_model_against<3>(const Model<3>&, VolumeSource&, Threads,
                                                      Progress&);

}  // namespace lode
