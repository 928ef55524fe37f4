#include "lode/api/verification.h"

#include <fmt/ranges.h>

#include <atomic>

#include "lode/mappers/lattice_frame.h"
#include "lode/mappers/surface_checks.h"
#include "lode/models/diamond/attribute_check.h"
#include "lode/models/diamond/boundary_check.h"
#include "lode/models/diamond/cut_check.h"
#include "lode/models/diamond/level_set_check.h"
#include "lode/models/diamond/model_samples.h"

namespace lode {
namespace {

using diamond::as_size;
using diamond::Model;

void add(VerifyReport& report, std::string name, std::uint64_t count, std::uint64_t failures,
         std::string detail) {
  report.checks.push_back({std::move(name), count, failures == 0, std::move(detail)});
}

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

template <int D>
Result<void> check_same_samples(const Model<D>& model, VolumeSource& original, Threads threads,
                                Progress& progress, VerifyReport& report) {
  const RegularGrid& grid = model.info.grid;
  if (original.info().grid.dims != grid.dims)
    return fail("expected an original of {} x {} x {} samples, got {} x {} x {}", grid.dims[0],
                grid.dims[1], grid.dims[2], original.info().grid.dims[0],
                original.info().grid.dims[1], original.info().grid.dims[2]);
  const std::string difference = difference_of(model.info, original.info());
  add(report, "grid and nodata equal the original's", 1, difference.empty() ? 0 : 1, difference);
  LODE_TRY(const Volume volume, read_all(original));
  const diamond::VolumeSamples theirs(volume);
  const diamond::ModelSamples<D> ours(model);
  std::atomic<std::uint64_t> n_different{0};
  std::atomic<std::int32_t> n_done{0};
  parallel_for(static_cast<std::size_t>(grid.dims[2]), threads, 1, [&](std::size_t z, int) {
    std::uint64_t n = 0;
    Index3 p{{0, 0, static_cast<std::int32_t>(z)}};
    for (p[1] = 0; p[1] < grid.dims[1] && !progress.is_cancelled(); ++p[1])
      for (p[0] = 0; p[0] < grid.dims[0]; ++p[0]) {
        const double a = theirs.sample(p);
        const double b = ours.sample(p);
        n += a == b || (!std::isfinite(a) && !std::isfinite(b)) ? 0 : 1;
      }
    n_different += n;
    progress.report("comparing samples", static_cast<double>(++n_done) / grid.dims[2]);
  });
  if (progress.is_cancelled()) return cancelled_error();
  add(report, "samples equal the original's", static_cast<std::uint64_t>(grid.n_samples()),
      n_different, fmt::format("{} differ", n_different.load()));
  return {};
}

void add(VerifyReport& report, std::string name, const diamond::AttributeFinding& finding) {
  add(report, std::move(name), finding.n_checked, finding.n_wrong,
      finding.n_wrong == 0 ? "" : fmt::format("{} wrong; {}", finding.n_wrong, finding.worst));
}

void add_topology(const Surface& surface, Threads threads, VerifyReport& report) {
  const TopologyReport t = check_topology(surface, {.may_pinch = {}, .threads = threads});
  add(report, "manifold edges", t.n_edges, t.non_manifold_edges.count,
      fmt::format("{} bad", t.non_manifold_edges.count));
  add(report, "consistent orientation", t.n_edges, t.inconsistent_edges.count,
      fmt::format("{} bad", t.inconsistent_edges.count));
  add(report, "manifold vertices", t.n_used_vertices, t.non_manifold_vertices.count,
      fmt::format("{} bad", t.non_manifold_vertices.count));
  add(report, "no degenerate cell", t.n_simplices, t.degenerate_simplices.count,
      fmt::format("{} bad", t.degenerate_simplices.count));
  add(report, "no duplicate vertex", t.n_used_vertices, t.duplicate_vertices.count,
      fmt::format("{} duplicates, {} hole twins", t.duplicate_vertices.count, t.n_twins));
}

/// Repeats the query and compares it with every sample.
template <int D>
Result<void> add_cut(const Model<D>& model, double isovalue, Threads threads, double tolerance,
                     Progress& progress, VerifyReport& report) {
  LODE_TRY(
      const auto cut,
      diamond::check_cut<D>(
          model, {.isovalue = isovalue, .tolerance = tolerance, .threads = threads}, progress));
  const bool is_achieved = cut.achieved_error <= tolerance && cut.n_too_far == 0;
  add(report, fmt::format("F' within the achieved error at {}", isovalue), cut.n_active_samples,
      is_achieved ? 0 : 1,
      fmt::format("largest {} of {}{}{}", cut.largest_difference, cut.achieved_error,
                  cut.n_too_far > 0 ? "; " : "", cut.n_too_far > 0 ? cut.worst : ""));
  add(report, fmt::format("no true surface outside the active simplices at {}", isovalue),
      cut.n_pruned_samples, cut.n_lost,
      cut.n_lost == 0 ? "" : fmt::format("{} simplices; {}", cut.n_lost, cut.worst));
  return {};
}

}  // namespace

template <int D>
Result<VerifyReport> verify_model_against(const Model<D>& model, VolumeSource& original,
                                          Threads threads, Progress& progress) {
  VerifyReport report;
  LODE_CHECK(check_same_samples<D>(model, original, threads, progress, report));
  LODE_TRY(const auto attributes, diamond::check_attributes<D>(model, threads, progress));
  add(report, "own errors <= stored errors", attributes.own_errors);
  add(report, "own ranges inside stored ranges", attributes.own_ranges);
  add(report, "stored values nested", attributes.nesting);
  add(report, "stored values no wider than rounding makes them", attributes.tightness);
  return report;
}

template <int D>
Result<VerifyReport> verify_model_surface(const Model<D>& model, const Surface& surface,
                                          const ExtractOptions& options, double tolerance,
                                          Progress& progress) {
  VerifyReport report;
  LODE_CHECK(check_well_formed(surface));
  add_topology(surface, options.threads, report);
  LODE_TRY(const auto crossings, check_self_intersections(surface, options.threads, progress));
  add(report, "no self-intersection", crossings.n_candidates, crossings.n_intersections,
      fmt::format("{} pairs meet", crossings.n_intersections));
  const bool is_closed = options.border == Border::closed;
  const diamond::ModelSamples<D> samples(model);
  const LatticeFrame frame = LatticeFrame::of(model.info.grid);
  const double range = model.stats.max - model.stats.min;
  const double slack = (frame.margin + 4 * frame.rounding) * range;
  LODE_TRY(
      const auto level_set,
      diamond::check_level_set(samples, surface,
                               {.isovalues = options.isovalues,
                                .tolerance = tolerance + slack,
                                .clip = options.clip,
                                .caps = is_closed ? diamond::Caps::on_border : diamond::Caps::none,
                                .threads = options.threads},
                               progress));
  add(report,
      is_closed ? "|F - isovalue| <= tolerance + slack; on caps isovalue - F"
                : "|F - isovalue| <= tolerance + slack",
      level_set.n_pieces, level_set.holds() ? 0 : 1,
      fmt::format("largest {} of {} + {}{}", level_set.max_deviation, tolerance, slack,
                  is_closed ? fmt::format("; {} caps", level_set.n_caps) : ""));
  LODE_TRY(const auto boundary,
           diamond::check_boundary(samples, surface,
                                   {.clip = options.clip, .threads = options.threads}, progress));
  if (is_closed)
    add(report, "closed but for holes", boundary.n_edges, boundary.n_stray + boundary.n_on_border,
        fmt::format("{} stray edges, {} at the border", boundary.n_stray, boundary.n_on_border));
  else
    add(report, "ends only at the border, holes and clip planes", boundary.n_edges,
        boundary.n_stray, fmt::format("{} stray edges", boundary.n_stray));
  for (const double isovalue : options.isovalues)
    LODE_CHECK(add_cut(model, isovalue, options.threads, tolerance, progress, report));
  return report;
}

template Result<VerifyReport> verify_model_against<2>(const Model<2>&, VolumeSource&, Threads,
                                                      Progress&);
template Result<VerifyReport> verify_model_against<3>(const Model<3>&, VolumeSource&, Threads,
                                                      Progress&);
template Result<VerifyReport> verify_model_surface<2>(const Model<2>&, const Surface&,
                                                      const ExtractOptions&, double, Progress&);
template Result<VerifyReport> verify_model_surface<3>(const Model<3>&, const Surface&,
                                                      const ExtractOptions&, double, Progress&);

}  // namespace lode
