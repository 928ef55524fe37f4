// Dataset::extract(): isosurfaces from a model in memory, or of a file chunk by chunk.

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <vector>

#include "lode/api/chunk_nodes.h"
#include "lode/api/dataset_impl.h"
#include "lode/api/file_build.h"
#include "lode/api/finishing.h"
#include "lode/api/isovalue_passes.h"
#include "lode/api/memory_extraction.h"
#include "lode/api/piece_finisher.h"
#include "lode/api/piece_simplifier.h"
#include "lode/api/simplification.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/models/diamond/close_border.h"
#include "lode/models/diamond/file_extract.h"
#include "lode/models/diamond/part_band.h"

namespace lode {
namespace {

Result<void> close_surface(const FieldFacts& field, const ExtractOptions& options, Surface& surface,
                           ExtractReport& report) {
  const bool is_inside = (field.first_sample >= options.isovalues.front()) != field.is_first_weak;
  if (surface.is_empty() && !is_inside && !std::isnan(field.first_sample)) return {};
  if (field.has_removed_border_cell)
    return fail("closing at the border: expected no holes there, but the field has some");
  LODE_TRY(const auto caps,
           diamond::close_border(field.grid, is_inside, options.normals == Normals::on,
                                 options.threads, surface));
  if (surface.isovalues.empty()) add_isovalue(options.isovalues.front(), options, surface);
  report.cap_cells = caps.n_cells;
  report.open_edges = caps.n_open;
  return {};
}

Result<void> finish_surface(const Dataset::Impl& impl, const FieldFacts& field,
                            const ExtractOptions& options, const SimplifyStart& start,
                            Surface& surface, ExtractReport& report, Progress& progress) {
  const Stopwatch watch;
  if (options.border == Border::closed) LODE_CHECK(close_surface(field, options, surface, report));
  const bool is_simplified = options.simplify != Simplify::off;
  ExtractOptions edits = options;
  // Simplified alike whichever way it is to face.
  if (is_simplified) edits.orientation = Orientation::from_lower_values;
  const Dropped dropped = finish_edits(edits, surface);
  report.components_dropped = dropped.components;
  report.triangles_dropped = dropped.cells;
  report.seconds.finish += watch.seconds();
  if (is_simplified) LODE_CHECK(simplify(impl, options, start, surface, report, progress));
  if (edits.orientation != options.orientation) flip_orientation(surface);
  report.triangles = surface.triangles.size();
  report.lines = surface.lines.size();
  report.vertices = surface.positions.size();
  report.unmet = unmet_isovalues(surface, options.isovalues);
  return {};
}

/// Of the limit what other isovalues' surfaces may take, while one is written.
constexpr std::uint64_t kHeldShare = 8;

std::uint64_t memory_limit_of(const ExtractOptions& options) {
  return options.memory_limit > 0 ? options.memory_limit : physical_memory() / 4;
}

/// For which simplifying takes a quarter of the memory limit.
std::size_t simplified_at_once(const ExtractOptions& options) {
  constexpr std::uint64_t kBytesPerTriangle = 200;  // 3.3 million took 0.6 GB
  return std::max<std::uint64_t>(20'000, memory_limit_of(options) / 4 / kBytesPerTriangle);
}

Result<void> extract_chunks(const Dataset::Impl& impl, Dataset::Impl::Chunks& chunks,
                            const ExtractOptions& options, const SimplifyStart& start,
                            Surface& surface, ExtractReport& report, Progress& progress) {
  surface.clear();
  SurfaceCollector collector(surface);
  ChunkNodes nodes(chunks, start.options, memory_limit_of(options));
  return std::visit(
      [&]<int D>(const diamond::CoarseField<D>& field) -> Result<void> {
        LODE_CHECK(extract_passes<D>(
            field, chunks.blocks, start.options, memory_limit_of(options) / kHeldShare, collector,
            report, [](double) {},
            [&](double isovalue) { add_isovalue(isovalue, options, surface); },
            nodes.begin(report, progress), progress));
        const FieldFacts facts{field.info.grid, false, field.value({}), nodes.is_first_weak()};
        return finish_surface(impl, facts, options, start, surface, report, progress);
      },
      chunks.field);
}

/// The same without ever having all of the surface. Within an error, what is simplified is of full
/// resolution: all tetrahedra, or what cubes keep to of it.
Result<void> stream_chunks(Dataset::Impl::Chunks& chunks, const ExtractOptions& options,
                           SurfaceSink& surface, ExtractReport& report, Progress& progress) {
  PieceFinisher finisher(options, surface);
  std::optional<PieceSimplifier> simplifier;
  const double tolerance = report.max_error;
  LODE_TRY(SimplifyStart start,
           start_of_simplification(
               options, std::visit([](const auto& field) { return field.info.grid; }, chunks.field),
               tolerance, nullptr, progress));
  const bool is_in_band = has_band(options, tolerance);
  if (is_in_band) {
    report.max_error = options.style == SurfaceStyle::cubes ? *start.options.max_error : 0;
    start.options.max_distance = options.max_distance;
    start.distance = 0;
  }
  ChunkNodes nodes(chunks, start.options, memory_limit_of(options));
  LODE_CHECK(std::visit(
      [&]<int D>(const diamond::CoarseField<D>& field) {
        if (options.simplify != Simplify::off)
          simplifier.emplace(simplify_options_of(options, start),
                             PieceShape{.grid = field.info.grid,
                                        .n_apart = diamond::n_pieces_apart<D>(field.shape),
                                        .max_triangles = simplified_at_once(options),
                                        .drops_components = drops_components(options)},
                             progress, finisher);
        SurfaceSink& sink = simplifier ? static_cast<SurfaceSink&>(*simplifier) : finisher;
        std::unique_ptr<SurfaceBand> band;
        diamond::SeePart<D> see_part;
        if constexpr (D == 3)
          if (is_in_band)
            see_part = [&](diamond::FilePart<3>& part) {
              band = diamond::make_part_band(part, field.info.grid, options.isovalues.front(),
                                             tolerance, options.threads);
              simplifier->set_band(band.get());
            };
        return extract_passes<D>(
            field, chunks.blocks, start.options, memory_limit_of(options) / kHeldShare, sink,
            report, [&](double isovalue) { finisher.begin(isovalue); }, [](double) {},
            nodes.begin(report, progress), progress, see_part);
      },
      chunks.field));
  report.max_error = tolerance;
  finisher.finish(report);
  if (simplifier) {
    report.simplified = simplifier->report();
    report.simplified->by_pieces = true;
    add_start(start, options, *report.simplified);
    const SimplifySeconds& seconds = report.simplified->seconds;
    report.seconds.simplify = seconds.collapse + seconds.check + seconds.finish;
    report.seconds.geometry = std::max(0.0, report.seconds.geometry - report.seconds.simplify);
  }
  return {};
}

/// Whether no edit needs to see all of the surface. At full resolution the pieces lie in boxes,
/// each in its own chunk's, where the grid's axes are the world's.
bool is_edited_by_piece(const ExtractOptions& options, const RegularGrid& grid, double tolerance) {
  const bool is_simplified_by_piece = (tolerance == 0 || has_band(options, tolerance)) &&
                                      options.isovalues.size() == 1 && grid.has_world_axes();
  return !options.clip && options.border == Border::open && options.min_component <= 1 &&
         (options.simplify == Simplify::off || is_simplified_by_piece);
}

/// At full resolution it is the surface that it is to be near.
void add_full_resolution(ExtractReport& report) {
  if (report.distance && report.max_error == 0) report.distance->full_triangles = report.triangles;
}

/// Errors of files are believed as far as they go: one of what was not refined tells where they are
/// not nested.
Result<void> check_within(const Dataset::Impl& impl, const ExtractReport& report) {
  if (report.achieved_error <= report.max_error) return {};
  return fail(
      "{}: expected errors that cover those of finer nodes, got {} below one within the max_error "
      "of {}: they are not those of the samples, as verifying the file tells",
      impl.path(), report.achieved_error, report.max_error);
}

/// What has been read of the file since then.
void add_reads(const store::ReadCounts& before, const Dataset::Impl& impl, ExtractReport& report) {
  const store::ReadCounts now = impl.reads();
  report.bytes_read = now.n_bytes - before.n_bytes;
  report.blocks_read = now.n_blocks - before.n_blocks;
}

/// What extract() goes by.
struct ExtractPlan {
  ExtractReport report;
  Dataset::Impl::Chunks* chunks = nullptr;  ///< Null: the model in memory.
};

/// What cannot be done by pieces of the model; null: all can.
const char* need_of_whole_model(const ExtractOptions& options, const RegularGrid& grid,
                                double tolerance) {
  if (has_band(options, tolerance) && !is_edited_by_piece(options, grid, tolerance))
    return "simplifying within a max_error, in a grid whose axes are not the world's";
  return nullptr;
}

/// What it takes beside the model in memory, for each triangle of full resolution in the style of
/// tetrahedra: finding nodes within a distance, or simplifying.
double bytes_per_triangle(const ExtractOptions& options, double tolerance) {
  constexpr double kFull = 75;  // as of find_distance_cut(), of whose cut no more are known
  constexpr double kCut = 130;
  constexpr double kSimplified = 160;  // 3.3 million took 0.52 GB
  constexpr double kShareOfCubes = 0.4;
  const bool is_near = before_simplification(options, tolerance).max_distance && tolerance > 0;
  double bytes = is_near ? kFull + kCut : 0;
  if (options.simplify != Simplify::off)
    bytes = std::max(
        bytes, options.style == SurfaceStyle::cubes ? kShareOfCubes * kSimplified : kSimplified);
  return bytes;
}

/// What a file's model, and what the options take beside it, come to in memory; where the model
/// alone is beyond the limit, that.
Result<std::uint64_t> bytes_of_whole(const Dataset::Impl& impl, const ExtractOptions& options,
                                     double tolerance, Progress& progress) {
  const std::uint64_t limit = memory_limit_of(options);
  const std::uint64_t model = impl.model_bytes();
  const double bytes = bytes_per_triangle(options, tolerance);
  if (bytes == 0 || model > limit || !impl.has_file()) return model;
  return impl.bytes_with_triangles(options.isovalues, bytes, limit, progress);
}

Result<ExtractPlan> plan_extraction(const Dataset::Impl& impl, const ExtractOptions& options,
                                    Progress& progress) {
  LODE_CHECK(check_extraction(impl, options));
  ExtractPlan plan;
  plan.report.max_error = tolerance_of(impl.summary().stats, options);
  const char* const need = need_of_whole_model(options, impl.info().grid, plan.report.max_error);
  const std::uint64_t limit = memory_limit_of(options);
  LODE_TRY(const std::uint64_t whole,
           bytes_of_whole(impl, options, plan.report.max_error, progress));
  const bool is_too_large = whole > limit;
  // Whether holes open the border is asked of all samples.
  const bool asks_all = options.border == Border::closed && impl.summary().stats.n_holes > 0;
  if (!asks_all) {
    if (options.memory_limit > 0 && is_too_large && impl.is_in_file() && impl.chunk_bytes() > limit)
      // What triangles may take beside the model is not counted where it is too large alone.
      return fail(
          "expected a memory limit of at least {} MB for {} samples of {} bytes, got {:g} MB",
          std::min(impl.chunk_bytes(), whole) / 1'000'000 + 1, impl.info().grid.n_samples(),
          size_of(impl.info().type), 1e-6 * static_cast<double>(limit));
    // Whatever was asked before, and is in memory for it.
    const bool beside_model = is_too_large && impl.model_bytes() <= limit;
    LODE_TRY(plan.chunks, impl.chunks(limit, beside_model));
  }
  // At full resolution all in memory is faster, and numbers vertices in another order; within a
  // distance it is faster and takes fewer nodes.
  const bool is_full = plan.report.max_error == 0 || options.style == SurfaceStyle::cubes;
  if (!is_too_large && (is_full || options.max_distance || need != nullptr ||
                        has_band(options, plan.report.max_error)))
    plan.chunks = nullptr;
  if (need != nullptr && plan.chunks != nullptr)
    return fail(
        "{}: expected a memory limit of at least {} MB, as it needs the whole model, got {:g} MB",
        need, whole / 1'000'000 + 1, 1e-6 * static_cast<double>(limit));
  if (asks_all && options.memory_limit > 0 && is_too_large && impl.is_in_file())
    return fail(
        "expected a memory limit of at least {} MB to close the surface of a field with holes, got "
        "{:g} MB",
        whole / 1'000'000 + 1, 1e-6 * static_cast<double>(limit));
  return plan;
}

}  // namespace

Result<ExtractReport> Dataset::extract(const ExtractOptions& options, Surface& surface,
                                       Progress& progress) const try {
  const Stopwatch watch;
  LODE_TRY(ExtractPlan plan, plan_extraction(*impl_, options, progress));
  ExtractReport& report = plan.report;
  const diamond::Model<3>* model = nullptr;
  if (plan.chunks == nullptr && options.simplify != Simplify::off) {
    LODE_TRY(const auto* const held, impl_->model(progress));
    model = std::get_if<diamond::Model<3>>(held);
  }
  LODE_TRY(const SimplifyStart start,
           start_of_simplification(options, impl_->info().grid, report.max_error, model, progress));
  if (options.isovalues.size() > 1) surface.clear();  // one replaces the surface in place
  if (plan.chunks != nullptr) {
    const store::ReadCounts before = impl_->reads();
    if (has_band(options, report.max_error)) {
      surface.clear();
      SurfaceCollector collector(surface);
      LODE_CHECK(stream_chunks(*plan.chunks, options, collector, report, progress));
    } else {
      LODE_CHECK(extract_chunks(*impl_, *plan.chunks, options, start, surface, report, progress));
    }
    add_full_resolution(report);
    add_reads(before, *impl_, report);
  } else {
    const double tolerance = report.max_error;
    report.max_error = start.options.max_error.value_or(tolerance);
    LODE_TRY(const FieldFacts field,
             extract_in_memory(*impl_, start.options, surface, report, progress));
    report.max_error = tolerance;
    LODE_CHECK(finish_surface(*impl_, field, options, start, surface, report, progress));
  }
  LODE_CHECK(check_within(*impl_, report));
  report.seconds.total = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the surface");
}

Result<bool> Dataset::comes_in_pieces(const ExtractOptions& options, Progress& progress) const try {
  LODE_TRY(const ExtractPlan plan, plan_extraction(*impl_, options, progress));
  return plan.chunks != nullptr &&
         is_edited_by_piece(options, impl_->info().grid, plan.report.max_error);
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the surface");
}

bool Dataset::takes_several_isovalues(const ExtractOptions& options) const {
  return !has_band(options, tolerance_of(impl_->summary().stats, options));
}

Result<ExtractReport> Dataset::extract(const ExtractOptions& options, SurfaceSink& surface,
                                       Progress& progress) const try {
  const Stopwatch watch;
  LODE_TRY(ExtractPlan plan, plan_extraction(*impl_, options, progress));
  ExtractReport& report = plan.report;
  if (plan.chunks != nullptr && is_edited_by_piece(options, impl_->info().grid, report.max_error)) {
    const store::ReadCounts before = impl_->reads();
    LODE_CHECK(stream_chunks(*plan.chunks, options, surface, report, progress));
    LODE_CHECK(check_within(*impl_, report));
    add_full_resolution(report);
    add_reads(before, *impl_, report);
  } else {
    SurfacePiece whole;
    LODE_TRY(report, extract(options, whole.surface, progress));
    LODE_CHECK(surface.add(std::move(whole)));
  }
  report.seconds.total = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("extract the surface");
}

}  // namespace lode
