#include "lode/api/dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <new>

#include "lode/api/dataset_impl.h"
#include "lode/api/file_build.h"
#include "lode/api/file_check.h"
#include "lode/api/salvage_report.h"
#include "lode/api/simplification.h"
#include "lode/api/topology_extraction.h"
#include "lode/api/verification.h"
#include "lode/core/out_of_memory.h"
#include "lode/models/diamond/build.h"
#include "lode/models/diamond/summary.h"

namespace lode {

namespace {

/// A volume one sample thick (or a 2D image) is a diamond2d.
bool is_flat(const Index3& dims) { return dims[0] == 1 || dims[1] == 1 || dims[2] == 1; }

Result<void> check_model(const store::Reader& reader) {
  const std::string& model = reader.model();
  if (model == diamond::model_name<2>() || model == diamond::model_name<3>()) return {};
  return fail("{}: expected a model diamond2d or diamond3d, got \"{}\"", reader.path(), model);
}

template <int D>
LevelInfo describe_level(const diamond::Shape<D>& shape, int level, double max_error) {
  LevelInfo info{.level = level, .step = std::int64_t{1} << level};
  std::uint64_t here = 1;
  std::uint64_t coarser = 1;
  std::uint64_t points = 1;
  std::uint64_t even = 1;
  const auto grid = shape.grid_dims(level);
  for (std::size_t i = 0; i < diamond::as_size(D); ++i) {
    const auto last = static_cast<std::uint64_t>(shape.dims[i] - 1);
    here *= (last >> level) + 1;
    coarser *= (last >> (level + 1)) + 1;
    points *= static_cast<std::uint64_t>(grid[i]);
    even *= static_cast<std::uint64_t>((grid[i] + 1) / 2);
  }
  info.n_samples = level == shape.n_levels - 1 ? here : here - coarser;
  info.n_nodes = level > 0 ? points - even : info.n_samples;
  info.max_error = max_error;
  return info;
}

template <int D>
std::vector<LevelInfo> describe_levels(const VolumeInfo& info, const diamond::Summary& summary) {
  const auto shape = diamond::shape_of<D>(info.grid.dims);
  std::vector<LevelInfo> levels;
  levels.reserve(summary.max_errors.size());
  for (int level = 0; level < shape.n_levels; ++level)
    levels.push_back(
        describe_level<D>(shape, level, summary.max_errors[static_cast<std::size_t>(level)]));
  return levels;
}

}  // namespace

Dataset::Dataset(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Dataset::Dataset(Dataset&&) noexcept = default;
Dataset& Dataset::operator=(Dataset&&) noexcept = default;
Dataset::~Dataset() = default;

Result<Dataset> Dataset::build(VolumeSource& source, const BuildOptions& options,
                               Progress& progress) try {
  const diamond::BuildSettings settings{.threads = options.threads};
  if (is_flat(source.info().grid.dims)) {
    LODE_TRY(auto model, diamond::build<2>(source, settings, progress));
    return Dataset(std::make_unique<Impl>(std::move(model)));
  }
  LODE_TRY(auto model, diamond::build<3>(source, settings, progress));
  return Dataset(std::make_unique<Impl>(std::move(model)));
} catch (const std::bad_alloc&) {
  return out_of_memory("build the hierarchy");
}

Result<Dataset> Dataset::open(const std::string& path, Threads threads) try {
  LODE_TRY(auto reader, store::Reader::open(path));
  LODE_CHECK(check_model(reader));
  LODE_TRY(auto metadata, diamond::read_metadata(reader));
  LODE_CHECK(diamond::check_current(reader, metadata));
  return Dataset(std::make_unique<Impl>(std::move(reader), std::move(metadata), threads));
} catch (const std::bad_alloc&) {
  return out_of_memory("open the file", path);
}

Result<Dataset> Dataset::salvage(const std::string& path, Threads threads, Progress& progress) try {
  LODE_TRY(const auto reader, open_damaged(path));
  LODE_CHECK(check_model(reader));
  const auto salvaged_as = [&]<int D>() -> Result<Dataset> {
    LODE_TRY(auto found, diamond::salvage<D>(reader, threads, progress));
    SalvageReport report = to_report(found.report, found.model.info.grid);
    return Dataset(std::make_unique<Impl>(std::move(found.model), std::move(report)));
  };
  return reader.model() == diamond::model_name<2>() ? salvaged_as.template operator()<2>()
                                                    : salvaged_as.template operator()<3>();
} catch (const std::bad_alloc&) {
  return out_of_memory("salvage the file", path);
}

const SalvageReport* Dataset::salvaged() const {
  return impl_->salvaged() ? &*impl_->salvaged() : nullptr;
}

Result<void> Dataset::load(Progress& progress) const try {
  const auto held = impl_->model(progress);
  if (!held) return held.error();
  return {};
} catch (const std::bad_alloc&) {
  return out_of_memory("load the file");
}

Result<void> Dataset::save(const std::string& path, Threads threads, Progress& progress) const try {
  LODE_TRY(const auto* const held, impl_->model(progress));
  return std::visit(
      [&]<int D>(const diamond::Model<D>& model) -> Result<void> {
        return diamond::save<D>(model, path, threads, progress);
      },
      *held);
} catch (const std::bad_alloc&) {
  return out_of_memory("write the file", path);
}

DatasetInfo Dataset::describe() const {
  const diamond::Summary& summary = impl_->summary();
  const bool is_2d = impl_->is_flat();
  DatasetInfo info{.model = is_2d ? diamond::model_name<2>() : diamond::model_name<3>(),
                   .volume = impl_->info(),
                   .range_min = summary.stats.min,
                   .range_max = summary.stats.max,
                   .n_holes = summary.stats.n_holes,
                   .n_removed_cells = summary.stats.n_removed_cells,
                   .base_error = summary.base_error,
                   .levels = is_2d ? describe_levels<2>(impl_->info(), summary)
                                   : describe_levels<3>(impl_->info(), summary)};
  if (const auto& stored = impl_->stored()) {
    info.data_bytes = stored->samples;
    info.attribute_bytes = stored->attributes;
    for (std::size_t i = 0; i < std::min(info.levels.size(), stored->by_level.size()); ++i)
      info.levels[i].bytes = stored->by_level[i];
  }
  return info;
}

FileReads Dataset::reads() const {
  const store::ReadCounts counts = impl_->reads();
  return {counts.n_blocks, counts.n_bytes};
}

Result<VerifyReport> Dataset::verify_against(VolumeSource& original, Threads threads,
                                             Progress& progress, std::uint64_t memory_limit) const
    try {
  const VolumeInfo& info = impl_->info();
  const std::uint64_t limit = memory_limit > 0 ? memory_limit : physical_memory();
  const std::uint64_t wanted =
      impl_->model_bytes() + original.memory_bytes() +
      static_cast<std::uint64_t>(info.grid.n_samples()) * size_of(original.info().type);
  if (impl_->is_in_file() && wanted > limit) {
    LODE_TRY(const auto reader, store::Reader::open(impl_->path()));
    const diamond::RebuildSettings settings{.threads = threads, .memory_limit = limit};
    LODE_TRY(VerifyReport report,
             impl_->is_flat() ? verify_samples_against<2>(reader, original, settings, progress)
                              : verify_samples_against<3>(reader, original, settings, progress));
    report.skip("errors by their definition",
                fmt::format("not looked at: takes about {} MB of memory, of {} MB; those of the "
                            "file's samples are above",
                            wanted / 1'000'000 + 1, limit / 1'000'000));
    return report;
  }
  LODE_TRY(const auto* const held, impl_->model(progress));
  return std::visit(
      [&]<int D>(const diamond::Model<D>& model) {
        return verify_model_against<D>(model, original, threads, progress);
      },
      *held);
} catch (const std::bad_alloc&) {
  return out_of_memory("compare the errors with the data");
}

Result<VerifyReport> Dataset::verify_bound(const Surface& surface, const BoundOptions& options,
                                           Progress& progress) const try {
  if (!(options.error >= 0))
    return fail("verify: expected an error bound of at least 0, got {}", options.error);
  LODE_TRY(const auto* const held, impl_->model(progress));
  return std::visit(
      [&]<int D>(const diamond::Model<D>& model) {
        return verify_surface_bound<D>(model, surface, options, progress);
      },
      *held);
} catch (const std::bad_alloc&) {
  return out_of_memory("check the surface");
}

namespace {

/// With each isovalue of a vertex the nearest of those that were asked for: a file may have rounded
/// it.
Surface with_isovalues_of(const Surface& surface, const std::vector<double>& isovalues) {
  Surface made = surface;
  for (double& value : made.isovalues)
    value = *std::ranges::min_element(isovalues, {},
                                      [&](double isovalue) { return std::abs(isovalue - value); });
  return made;
}

bool has_rounded_isovalues(const Surface& surface, const std::vector<double>& isovalues) {
  return isovalues.size() > 1 && std::ranges::any_of(surface.isovalues, [&](double value) {
           return std::ranges::find(isovalues, value) == isovalues.end();
         });
}

}  // namespace

Result<VerifyReport> Dataset::verify_surface(const Surface& surface, const ExtractOptions& options,
                                             Progress& progress) const try {
  LODE_CHECK(check_extraction(*impl_, options));
  if (has_rounded_isovalues(surface, options.isovalues))
    return verify_surface(with_isovalues_of(surface, options.isovalues), options, progress);
  const double tolerance = tolerance_of(impl_->summary().stats, options);
  ExtractOptions again = before_simplification(options, tolerance);
  again.normals = Normals::off;
  again.deviation = Deviation::measured;
  Surface expected;
  LODE_TRY(const ExtractReport report, extract(again, expected, progress));
  Surface full;
  const bool is_held_to_pieces =
      options.keep_topology && (*options.keep_topology == 0 || options.simplify != Simplify::off);
  const bool needs_full = options.max_distance || is_held_to_pieces || has_band(options, tolerance);
  // What does not persist is left out of all that a simplified surface is held against.
  if (options.simplify == Simplify::off || !leaves_out_weak(again)) again.keep_topology.reset();
  again.max_distance.reset();
  again.max_error = 0;
  if (needs_full)
    if (auto done = extract(again, full, progress); !done) return done.error();
  Surface level_set;
  const bool has_cubes =
      options.style == SurfaceStyle::cubes && tolerance == 0 && options.min_component <= 1;
  if (has_cubes) {
    again.style = SurfaceStyle::tetra;
    again.style_distance.reset();
    again.keep_topology = options.keep_topology;  // left out of both
    if (auto done = extract(again, level_set, progress); !done) return done.error();
  }
  LODE_TRY(const auto* const held, impl_->model(progress));
  return std::visit(
      [&]<int D>(const diamond::Model<D>& model) {
        return verify_model_surface<D>(
            model, surface,
            {.surface = expected,
             .tolerance = options.max_distance ? report.achieved_error : tolerance,
             .style_error = report.style_error,
             .full_resolution = needs_full ? &full : nullptr,
             .level_set = has_cubes ? &level_set : nullptr,
             .max_distance = options.max_distance.value_or(0),
             .keep_topology = options.keep_topology},
            options, progress);
      },
      *held);
} catch (const std::bad_alloc&) {
  return out_of_memory("check the surface");
}

Result<VerifyReport> verify_file(const std::string& path, Threads threads, Progress& progress,
                                 std::uint64_t memory_limit) try {
  LODE_TRY(VerifyReport report, verify_every_byte(path, threads, progress));
  LODE_TRY(const auto reader, store::Reader::open(path));
  LODE_CHECK(check_model(reader));
  const diamond::RebuildSettings settings{
      .threads = threads, .memory_limit = memory_limit > 0 ? memory_limit : physical_memory()};
  LODE_CHECK(reader.model() == diamond::model_name<2>()
                 ? verify_attributes<2>(reader, settings, progress, report)
                 : verify_attributes<3>(reader, settings, progress, report));
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("check the file", path);
}

}  // namespace lode
