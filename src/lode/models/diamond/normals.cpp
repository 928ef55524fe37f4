#include "lode/models/diamond/normals.h"

#include "lode/models/diamond/inner_gradients.h"

namespace lode::diamond {
namespace {

/// run(begin, end) of chunks of n.
template <typename Run>
void for_each_chunk(std::size_t n, Threads threads, const Run& run) {
  constexpr std::size_t kChunk = 1 << 12;
  parallel_for((n + kChunk - 1) / kChunk, threads, 1, [&](std::size_t chunk, int) {
    run(chunk * kChunk, std::min(n, (chunk + 1) * kChunk));
  });
}

}  // namespace

template <>
void compute_normals<2>(const Model<2>& model, std::span<const EdgePoint> points, Threads threads,
                        std::span<Vec3f> normals) {
  visit_storage_type(model.storage, [&]<typename T>() {
    const NormalSampler<2, T> sampler(model);
    for_each_chunk(points.size(), threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) normals[v] = sampler.at(points[v]);
    });
  });
}

template <>
void compute_normals<3>(const Model<3>& model, std::span<const EdgePoint> points, Threads threads,
                        std::span<Vec3f> normals) {
  visit_storage_type(model.storage, [&]<typename T>() {
    const NormalSampler<3, T> sampler(model);
    const InnerGradients<T> inner(model);
    const bool has_holes = model.has_holes();
    const auto find = [&](const Index3& p, std::int32_t step, double* out) {
      if (has_holes || !inner.find(p, step, out)) sampler.put(p, step, out);
    };
    for_each_chunk(points.size(), threads, [&](std::size_t begin, std::size_t end) {
      write_normals(begin, end, sampler.frame(), normals.data(),
                    [&](std::size_t i, double* out) { put_gradient(points[i], find, out); });
    });
  });
}

}  // namespace lode::diamond
