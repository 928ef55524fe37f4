#include "lode/models/diamond/build.h"

#include <optional>

#include "lode/core/parallel_fill.h"
#include "lode/models/diamond/encode_blocks.h"
#include "lode/models/diamond/error_pass.h"
#include "lode/models/diamond/nesting_pass.h"
#include "lode/models/diamond/world_pass.h"

namespace lode::diamond {
namespace {

NodeLevel make_level(std::size_t n, Threads threads) {
  NodeLevel level;
  fill_anew(level.error, n, ErrorCode{0}, threads);
  level.low.resize(n);
  level.high.resize(n);
  return level;
}

template <int D, typename V>
Result<void> build_attributes_as(Model<D>& model, bool with_worlds, Threads threads,
                                 Progress& progress) {
  model.levels.clear();
  model.worlds.clear();
  for (int level = 0; level < model.shape.n_levels; ++level)
    model.levels.push_back(make_level(n_points<D>(model.shape.attribute_dims(level)), threads));
  OwnErrors own(model.levels.size());
  for (std::size_t level = 1; level < own.size(); ++level) own[level] = model.levels[level].error;
  if (with_worlds) model.worlds = no_worlds<D>(model.shape, threads);
  UninitializedArray<WorldCode>* const leaf_worlds = with_worlds ? model.worlds.data() : nullptr;
  LODE_CHECK((find_own_errors<D, V>(model, own, &model.levels[0], leaf_worlds, threads, progress)));
  if (with_worlds) find_worlds<D, typename SampleScale<D, V>::C>(model, own, threads, model.worlds);
  NestingPass<D, Model<D>>(model, 1, model.shape.n_levels, threads).run();
  round_ranges<D, Model<D>>(model, model.levels, 1, threads);  // level 0's are not stored
  return {};
}

template <int D, typename V>
void compute_level_0_as(Model<D>& model, Threads threads) {
  model.levels[0] = make_level(n_points<D>(model.shape.attribute_dims(0)), threads);
  find_leaf_attributes<V>(
      model, model.n_bricks(), threads,
      [&](std::size_t i) { return point_of<D>(model.brick_dims, i); },
      [&](const Index<D>& brick, V* values) { gather_values<D>(model, brick, 1, values); });
}

template <int D>
Result<void> read_samples(Model<D>& model, VolumeSource& source, const BuildSettings& settings,
                          Progress& progress) {
  const Index3 dims = model.info.grid.dims;
  const std::int64_t slice_samples = std::int64_t{dims[0]} * dims[1];
  const std::size_t size = size_of(model.info.type);
  constexpr std::int64_t kBytesPerRead = std::int64_t{4} << 20;  // reused while it is in a cache
  std::int32_t slices = settings.slices_per_read;
  if (slices <= 0)
    slices = static_cast<std::int32_t>(std::clamp<std::int64_t>(
        kBytesPerRead / (slice_samples * static_cast<std::int64_t>(size)), 1, dims[2]));
  const auto n = static_cast<std::size_t>(slice_samples * std::min(slices, dims[2]));
  std::vector<std::byte> bytes(n * size);
  std::vector<std::byte> widened(model.storage == model.info.type ? 0 : n * model.sample_size());
  for (std::int32_t z = 0; z < dims[2]; z += slices) {
    if (progress.is_cancelled()) return cancelled_error();
    progress.report("reading", static_cast<double>(z) / dims[2],
                    static_cast<std::uint64_t>(slice_samples * dims[2]) * size);
    const IndexBox box{{{0, 0, z}}, {{dims[0], dims[1], std::min(z + slices, dims[2])}}};
    const auto n_read = static_cast<std::size_t>(box.n_samples());
    LODE_CHECK(source.read(box, std::span(bytes).first(n_read * size)));
    if (!widened.empty()) widen_samples(model.info.type, bytes.data(), n_read, widened.data());
    LatticeBox<D> part;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      part.lower[i] = box.lower[as_size(model.axes.axis[i])];
      part.upper[i] = box.upper[as_size(model.axes.axis[i])];
    }
    put_samples<D>(model, part, widened.empty() ? bytes.data() : widened.data(), settings.threads);
  }
  finish_samples<D>(model, settings.threads);
  return check_magnitude(model.stats);
}

}  // namespace

Result<void> check_axes(const VolumeInfo& info) {
  for (std::size_t i = 0; i < 3; ++i)
    if (info.grid.dims[i] < 1 || info.grid.dims[i] > kMaxSamplesPerAxis)
      return fail("expected 1 to {} samples along each axis, got {} along axis {}",
                  kMaxSamplesPerAxis, info.grid.dims[i], i);
  return {};
}

template <int D>
Result<Model<D>> build(VolumeSource& source, const BuildSettings& settings, Progress& progress) {
  const VolumeInfo& info = source.info();
  LODE_CHECK(check_axes(info));
  Model<D> model = Model<D>::make(info);
  LODE_CHECK(read_samples<D>(model, source, settings, progress));
  LODE_CHECK(build_attributes<D>(model, settings.with_worlds, settings.threads, progress));
  return model;
}

template <int D>
Result<void> build_attributes(Model<D>& model, bool with_worlds, Threads threads,
                              Progress& progress) {
  return visit_held_type<D>(model, [&]<typename V>() {
    return build_attributes_as<D, V>(model, with_worlds, threads, progress);
  });
}

template <int D>
void compute_level_0(Model<D>& model, Threads threads) {
  visit_held_type<D>(model, [&]<typename V>() { compute_level_0_as<D, V>(model, threads); });
}

template Result<Model<2>> build<2>(VolumeSource&, const BuildSettings&, Progress&);
template Result<Model<3>> build<3>(VolumeSource&, const BuildSettings&, Progress&);
template Result<void> build_attributes<2>(Model<2>&, bool, Threads, Progress&);
template Result<void> build_attributes<3>(Model<3>&, bool, Threads, Progress&);
template void compute_level_0<2>(Model<2>&, Threads);
template void compute_level_0<3>(Model<3>&, Threads);

}  // namespace lode::diamond
