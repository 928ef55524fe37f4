#include "lode/models/diamond/salvage.h"

#include "lode/models/diamond/block_checks.h"
#include "lode/models/diamond/build.h"
#include "lode/models/diamond/salvaged_samples.h"

namespace lode::diamond {
namespace {

/// Grid indices of the region's samples in the data.
template <int D>
IndexBox box_of(const Model<D>& model, const Region<D>& r) {
  Index<D> lower;
  Index<D> upper;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    lower[i] = r.lower[i] << r.level;
    upper[i] = std::min(((r.upper[i] - 1) << r.level) + 1, model.shape.dims[i]);
  }
  // An axis that the lattice leaves aside has one sample.
  IndexBox box{model.axes.to_grid(lower), model.axes.to_grid(upper)};
  for (std::size_t i = 0; i < 3; ++i) box.upper[i] = std::max(box.upper[i], box.lower[i] + 1);
  return box;
}

template <int D>
void add_lost(const Model<D>& model, const LostRegion<D>& block,
              const typename SalvagedSamples<D>::Filled& filled, SalvageReport& report) {
  LostBlock lost{.key = key_of(block.kind, block.region),
                 .reason = block.reason,
                 .n_samples = filled.n_lost,
                 .n_holes = filled.n_holes,
                 .box = {},
                 .max_error = filled.max_error};
  if (filled.n_lost > 0) lost.box = box_of<D>(model, block.region);
  report.n_samples += lost.n_samples;
  report.n_holes += lost.n_holes;
  report.max_error = std::max(report.max_error, lost.max_error);
  report.lost.push_back(std::move(lost));
}

/// Whether the file had world errors; what was cut off may have.
bool had_worlds(const store::Reader& reader) { return reader.is_rebuilt() || has_worlds(reader); }

/// Blocks that a whole file of the model has, without indexes.
template <int D>
std::uint64_t count_blocks(const Shape<D>& shape, std::span<const Kind> kinds) {
  std::uint64_t n = 0;
  for (const Kind kind : kinds)
    for (const Region<D>& r : all_regions<D>(shape, kind)) n += count_points(r) > 0 ? 1 : 0;
  return n;
}

/// Puts the samples that the file has, and fills the others.
template <int D>
Result<SalvageReport> put_salvaged(Model<D>& model, const store::Reader& reader,
                                   const Metadata& metadata, Threads threads, Progress& progress) {
  std::vector<Kind> kinds{Kind::samples, Kind::errors, Kind::lows, Kind::highs};
  if (had_worlds(reader)) kinds.push_back(Kind::worlds);
  SalvageReport report{.n_blocks = count_blocks<D>(model.shape, kinds), .lost = {}};
  std::vector<LostRegion<D>> lost;
  LODE_TRY(auto samples, SalvagedSamples<D>::load(reader, metadata, threads, progress, lost));
  std::vector<LostRegion<D>> lost_nodes;
  LODE_TRY(const auto nodes, KnownNodes<D>::load(reader, metadata, threads, progress, lost_nodes));
  // World errors say nothing of samples.
  std::vector<Region<D>> regions;
  if (had_worlds(reader)) regions = all_regions<D>(model.shape, Kind::worlds);
  const auto accept = [](std::size_t, const std::vector<std::byte>&) { return Result<void>(); };
  LODE_CHECK(salvage_blocks<D>(reader, regions, Kind::worlds, sizeof(WorldCode), threads, progress,
                               accept, lost_nodes));
  LODE_TRY(const auto filled, samples.fill(nodes, lost, threads, progress));
  for (std::size_t i = 0; i < lost.size(); ++i) add_lost<D>(model, lost[i], filled[i], report);
  for (const LostRegion<D>& block : lost_nodes) add_lost<D>(model, block, {}, report);
  report.n_lost_holes = samples.n_lost_holes();
  put_samples<D>(model, {{}, model.shape.dims}, samples.all(), threads);
  return report;
}

}  // namespace

template <int D>
Result<Salvaged<D>> salvage(const store::Reader& reader, Threads threads, Progress& progress) {
  LODE_TRY(const Metadata metadata, read_metadata(reader));
  Salvaged<D> salvaged{Model<D>::make(metadata.info), {}};
  Model<D>& model = salvaged.model;
  LODE_TRY(salvaged.report, put_salvaged<D>(model, reader, metadata, threads, progress));
  finish_samples<D>(model, threads);
  const bool is_original = salvaged.report.n_samples == 0;
  if (is_original) LODE_CHECK(check_stats(reader, metadata.summary.stats, model.stats));
  LODE_CHECK(build_attributes<D>(model, true, threads, progress));
  // What was written before the blocks knows no errors, and older files knew others.
  if (is_original && !reader.is_rebuilt() && has_current_errors(reader, metadata))
    LODE_CHECK(check_errors(reader, metadata.summary, summarize<D>(model)));
  return salvaged;
}

template Result<Salvaged<2>> salvage<2>(const store::Reader&, Threads, Progress&);
template Result<Salvaged<3>> salvage<3>(const store::Reader&, Threads, Progress&);

}  // namespace lode::diamond
