#include "lode/models/diamond/normals.h"

namespace lode::diamond {

template <int D>
void compute_normals(const Model<D>& model, std::span<const EdgePoint> points, Threads threads,
                     std::span<Vec3f> normals) {
  constexpr std::size_t kChunk = 1 << 12;
  visit_storage_type(model.storage, [&]<typename T>() {
    const NormalSampler<D, T> sampler(model);
    parallel_for((points.size() + kChunk - 1) / kChunk, threads, 1, [&](std::size_t chunk, int) {
      for (std::size_t v = chunk * kChunk; v < std::min(points.size(), (chunk + 1) * kChunk); ++v)
        normals[v] = sampler.at(points[v]);
    });
  });
}

template void compute_normals<2>(const Model<2>&, std::span<const EdgePoint>, Threads,
                                 std::span<Vec3f>);
template void compute_normals<3>(const Model<3>&, std::span<const EdgePoint>, Threads,
                                 std::span<Vec3f>);

}  // namespace lode::diamond
