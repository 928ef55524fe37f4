#include "lode/models/diamond/build.h"

#include <atomic>
#include <memory>

#include "lode/models/diamond/error_pass.h"
#include "lode/models/diamond/nesting_pass.h"

namespace lode::diamond {
namespace {

/// value - reference rounded to float32, downward (direction < 0) or upward.
float outward(double value, double reference, double direction) {
  double difference = value - reference;
  if (reference != 0)
    difference = std::nextafter(difference, direction * std::numeric_limits<double>::infinity());
  const float f = static_cast<float>(difference);
  const bool is_outward =
      direction < 0 ? static_cast<double>(f) <= difference : static_cast<double>(f) >= difference;
  if (is_outward) return f;
  return std::nextafter(f, static_cast<float>(direction) * std::numeric_limits<float>::infinity());
}

template <int D, typename C>
NodeLevel encode(const Model<D>& model, const RawLevel<C>& raw, Threads threads) {
  NodeLevel level;
  const std::size_t n = raw.error.size();
  level.error.resize(n);
  level.low.resize(n);
  level.high.resize(n);
  const double reference = model.range_reference();
  constexpr std::size_t kChunk = 1 << 14;
  parallel_for((n + kChunk - 1) / kChunk, threads, 1, [&](std::size_t chunk, int) {
    for (std::size_t i = chunk * kChunk; i < std::min(n, (chunk + 1) * kChunk); ++i) {
      level.error[i] = encode_error(raw.error[i]);
      level.low[i] = outward(static_cast<double>(raw.low[i]), reference, -1);
      level.high[i] = outward(static_cast<double>(raw.high[i]), reference, 1);
    }
  });
  return level;
}

template <int D, typename C>
Result<void> build_attributes(Model<D>& model, Threads threads, Progress& progress) {
  LODE_TRY(std::vector<RawLevel<C>> raw, (find_own_errors<D, C>(model, threads, progress)));
  NestingPass<D, C>(model, raw, threads).run();
  model.levels.clear();
  for (RawLevel<C>& level : raw) {
    model.levels.push_back(encode<D>(model, level, threads));
    level = RawLevel<C>(0);
  }
  return {};
}

template <int D, typename C>
void compute_level_0_as(Model<D>& model, Threads threads) {
  std::vector<RawLevel<C>> raw;
  raw.emplace_back(n_points<D>(level_dims<D>(model.shape, 0)));
  std::vector<std::unique_ptr<ErrorPass<D, C>>> passes(as_size(n_workers(threads)));
  parallel_for(model.n_bricks(), threads, 1, [&](std::size_t i, int worker) {
    auto& pass = passes[as_size(worker)];
    if (!pass) pass = std::make_unique<ErrorPass<D, C>>(model, raw);
    const Index<D> brick = point_of<D>(model.brick_dims, i);
    pass->gather_only(brick);
    pass->put_leaf_attributes(brick);
  });
  model.levels[0] = encode<D>(model, raw[0], threads);
}

template <int D>
Result<void> read_samples(Model<D>& model, VolumeSource& source, const BuildSettings& settings,
                          Progress& progress) {
  const Index3 dims = model.info.grid.dims;
  const std::int64_t slice_samples = std::int64_t{dims[0]} * dims[1];
  const std::size_t size = size_of(model.info.type);
  constexpr std::int64_t kBytesPerRead = std::int64_t{16} << 20;
  std::int32_t slices = settings.slices_per_read;
  if (slices <= 0)
    slices = static_cast<std::int32_t>(std::clamp<std::int64_t>(
        kBytesPerRead / (slice_samples * static_cast<std::int64_t>(size)), 1, dims[2]));
  const auto n = static_cast<std::size_t>(slice_samples * std::min(slices, dims[2]));
  std::vector<std::byte> bytes(n * size);
  std::vector<std::byte> widened(model.storage == model.info.type ? 0 : n * model.sample_size());
  for (std::int32_t z = 0; z < dims[2]; z += slices) {
    if (progress.is_cancelled()) return cancelled_error();
    progress.report("reading", static_cast<double>(z) / dims[2]);
    const IndexBox box{{{0, 0, z}}, {{dims[0], dims[1], std::min(z + slices, dims[2])}}};
    const auto n_read = static_cast<std::size_t>(box.n_samples());
    LODE_CHECK(source.read(box, std::span(bytes).first(n_read * size)));
    if (!widened.empty()) widen_samples(model.info.type, bytes.data(), n_read, widened.data());
    Index<D> lower;
    Index<D> upper;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      lower[i] = box.lower[as_size(model.axes.axis[i])];
      upper[i] = box.upper[as_size(model.axes.axis[i])];
    }
    put_samples<D>(model, lower, upper, widened.empty() ? bytes.data() : widened.data());
  }
  finish_samples<D>(model, settings.threads);
  return {};
}

}  // namespace

template <int D>
Result<Model<D>> build(VolumeSource& source, const BuildSettings& settings, Progress& progress) {
  const VolumeInfo& info = source.info();
  for (std::size_t i = 0; i < 3; ++i)
    if (info.grid.dims[i] < 1 || info.grid.dims[i] > kMaxSamplesPerAxis)
      return fail("expected 1 to {} samples along each axis, got {} along axis {}",
                  kMaxSamplesPerAxis, info.grid.dims[i], i);
  Model<D> model = Model<D>::make(info);
  LODE_CHECK(read_samples<D>(model, source, settings, progress));
  if (is_exact_in_float<D>(model))
    LODE_CHECK((build_attributes<D, float>(model, settings.threads, progress)));
  else
    LODE_CHECK((build_attributes<D, double>(model, settings.threads, progress)));
  return model;
}

template <int D>
void compute_level_0(Model<D>& model, Threads threads) {
  if (is_exact_in_float<D>(model))
    compute_level_0_as<D, float>(model, threads);
  else
    compute_level_0_as<D, double>(model, threads);
}

template Result<Model<2>> build<2>(VolumeSource&, const BuildSettings&, Progress&);
template Result<Model<3>> build<3>(VolumeSource&, const BuildSettings&, Progress&);
template void compute_level_0<2>(Model<2>&, Threads);
template void compute_level_0<3>(Model<3>&, Threads);

}  // namespace lode::diamond
