#include "lode/api/tetra_dataset.h"

#include <array>
#include <cstdint>
#include <functional>
#include <new>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lode/api/tetra_build.h"
#include "lode/api/tetra_dataset_impl.h"
#include "lode/api/tetra_info.h"
#include "lode/api/tetra_query.h"
#include "lode/api/tetra_session.h"
#include "lode/api/tetra_verification.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/mappers/mesh_isosurface.h"
#include "lode/models/tetra_mt/gradient_codes.h"
#include "lode/models/tetra_mt/midpoint/persist.h"
#include "lode/models/tetra_mt/persist.h"
#include "lode/store/reader.h"

namespace lode {
namespace {

using tetra_mt::kNone;
using Midpoints = tetra_mt::midpoint::Forest;
using tetra_mt::PackedHierarchy;

/// What positions of surfaces are relative to: nothing, unless the mesh is so far away that float32
/// loses more than a millionth of its size.
Vec3d origin_of(const Box3d& box) {
  constexpr double kFar = 16;
  const bool is_far = length(box.lower) + length(box.upper) > kFar * length(box.upper - box.lower);
  return is_far ? box.lower : Vec3d();
}

}  // namespace

TetraDataset::Impl::Impl(PackedHierarchy packed, GradientSource source,
                         std::function<tetra_mt::FileReads()> reads_of)
    : hierarchy(std::move(packed)),
      reads(std::move(reads_of)),
      info(info_of(hierarchy->head())),
      surface_origin(origin_of(info.bounds)),
      surface_margin(
          rounding_margin(std::array{info.bounds.lower, info.bounds.upper}, surface_origin)),
      source_(std::move(source)) {}
TetraDataset::Impl::Impl(Midpoints made, std::function<tetra_mt::FileReads()> reads_of)
    : midpoints(std::move(made)),
      reads(std::move(reads_of)),
      info(info_of(midpoints->head())),
      surface_origin(origin_of(info.bounds)),
      surface_margin(
          rounding_margin(std::array{info.bounds.lower, info.bounds.upper}, surface_origin)) {}

TetraDataset::TetraDataset(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TetraDataset::TetraDataset(TetraDataset&&) noexcept = default;
TetraDataset& TetraDataset::operator=(TetraDataset&&) noexcept = default;
TetraDataset::~TetraDataset() = default;

const TetraInfo& TetraDataset::describe() const { return impl_->info; }

TetraReads TetraDataset::reads() const {
  if (!impl_->reads) return {};
  const tetra_mt::FileReads reads = impl_->reads();
  return {reads.n_bytes, reads.file_size};
}

Result<TetraDataset> TetraDataset::build(const TetraMesh& mesh, const TetraBuildOptions& options,
                                         Progress& progress) try {
  if (options.placement == Placement::midpoint) {
    LODE_TRY(auto midpoints, build_midpoints(mesh, options, progress));
    return TetraDataset(std::make_unique<Impl>(Midpoints(std::move(midpoints))));
  }
  LODE_TRY(const auto hierarchy, build_hierarchy(mesh, options, progress));
  std::vector<std::vector<std::uint32_t>> codes;
  for (std::size_t f = 0; f < mesh.fields.size(); ++f)
    codes.push_back(gradient_codes(mesh, f, hierarchy.mesh_vertices, options.threads));
  auto packed = PackedHierarchy::pack(hierarchy, mesh.tetrahedra.size(), options.threads);
  auto source = [codes = std::move(codes), shape = packed.head().shape](std::size_t field,
                                                                        std::uint32_t page) {
    const tetra_mt::VertexRange range = vertices_of(shape, page);
    const auto begin = codes[field].begin() + static_cast<std::ptrdiff_t>(range.first);
    return Result(std::vector<std::uint32_t>(begin, begin + range.n));
  };
  return TetraDataset(std::make_unique<Impl>(std::move(packed), std::move(source)));
} catch (const std::bad_alloc&) {
  return out_of_memory("build the hierarchy");
}

bool TetraDataset::is_model_of(const std::string& path) {
  const auto name = store::Reader::model_of(path);
  return name && (*name == tetra_mt::kModelName || *name == tetra_mt::midpoint::kModelName);
}

Result<TetraDataset> TetraDataset::open(const std::string& path) try {
  if (tetra_mt::midpoint::is_model_of(path)) {
    LODE_TRY(auto opened, tetra_mt::midpoint::open(path));
    return TetraDataset(std::make_unique<Impl>(std::move(opened.forest), std::move(opened.reads)));
  }
  LODE_TRY(auto opened, tetra_mt::open(path));
  auto impl = std::make_unique<Impl>(std::move(opened.hierarchy), std::move(opened.gradients),
                                     std::move(opened.reads));
  impl->info.is_lean = !impl->has_gradients();
  return TetraDataset(std::move(impl));
} catch (const std::bad_alloc&) {
  return out_of_memory("open the file");
}

Result<const std::vector<std::uint32_t>*> TetraDataset::Impl::load_gradients(
    std::size_t field, std::uint32_t page) const {
  auto& codes = pages_[{field, page}];
  if (codes.empty()) {
    LODE_TRY(codes, source_(field, page));
  }
  return &codes;
}

Result<std::vector<Vec3f>> TetraDataset::Impl::gradients(std::span<const std::uint32_t> vertices,
                                                         std::size_t field) const {
  const std::lock_guard lock(mutex_);
  const tetra_mt::PageShape& shape = hierarchy->head().shape;
  std::vector<Vec3f> found;
  found.reserve(vertices.size());
  std::uint32_t page = kNone;
  const std::vector<std::uint32_t>* codes = nullptr;
  for (const std::uint32_t v : vertices) {
    if (codes == nullptr || page_of(shape, v) != page) {
      page = page_of(shape, v);
      LODE_TRY(codes, load_gradients(field, page));
    }
    found.push_back(tetra_mt::gradient_of((*codes)[v - vertices_of(shape, page).first]));
  }
  return found;
}

Result<MeshReport> TetraDataset::extract_mesh(const TetraMeshOptions& options, SimplexMesh& mesh,
                                              Progress& progress) const {
  return TetraSession(*this).extract_mesh(options, mesh, progress);
}

Result<TetraSurfaceReport> TetraDataset::extract_surface(const TetraSurfaceOptions& options,
                                                         Surface& surface,
                                                         Progress& progress) const {
  return TetraSession(*this).extract_surface(options, surface, progress);
}

Result<TetraSurfaceReport> TetraDataset::extract_section(const TetraSectionOptions& options,
                                                         Surface& surface,
                                                         Progress& progress) const {
  return TetraSession(*this).extract_section(options, surface, progress);
}

Result<TetraSurfaceReport> TetraDataset::extract_boundary(const TetraMeshOptions& options,
                                                          Surface& surface,
                                                          Progress& progress) const {
  return TetraSession(*this).extract_boundary(options, surface, progress);
}

Result<ProbeReport> TetraDataset::probe(std::span<const Vec3d> points, const ProbeOptions& options,
                                        std::vector<ProbedPoint>& found, Progress& progress) const
    try {
  const Stopwatch watch;
  LODE_TRY(ProbeReport report, probe_hierarchy(impl_->probed(), points, options, found, progress));
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("probe the field");
}

Result<ProbeReport> TetraDataset::probe_line(const ProbedLine& line, const ProbeOptions& options,
                                             std::vector<ProbedLinePoint>& found,
                                             Progress& progress) const try {
  const Stopwatch watch;
  LODE_TRY(ProbeReport report, probe_hierarchy(impl_->probed(), line, options, found, progress));
  report.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("probe the field");
}

Result<IntegralReport> TetraDataset::integrate(const IntegralOptions& options,
                                               Progress& progress) const try {
  const Stopwatch watch;
  LODE_CHECK(check_regions(impl_->info, options.regions));
  LODE_TRY(IntegralReport report, integrate_hierarchy(impl_->probed(), options, progress));
  report.probe.seconds = watch.seconds();
  return report;
} catch (const std::bad_alloc&) {
  return out_of_memory("integrate the field");
}

Result<VerifyReport> TetraDataset::verify(const TetraVerifyOptions& options,
                                          Progress& progress) const try {
  LODE_CHECK(check_fields(impl_->info, {.along = options.fields}));
  return verify_hierarchy(*impl_->source(), options, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("check the hierarchy");
}

Result<VerifyReport> TetraDataset::verify_against(const TetraMesh& original,
                                                  std::span<const std::size_t> fields,
                                                  Progress& progress) const try {
  LODE_CHECK(check_fields(impl_->info, {.along = {fields.begin(), fields.end()}}));
  return compare_with_original(*impl_->source(), original, fields, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("compare the hierarchy with the data");
}

}  // namespace lode
