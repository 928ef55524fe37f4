#include "lode/delaunay/greedy_insertion.h"

#include <optional>

#include "lode/delaunay/greedy_loop.h"
#include "lode/delaunay/triangle_judge.h"

namespace lode::delaunay {

template <typename T>
Result<GreedyReport> insert_greedily(LatticeMesh& mesh, const SampleRows<T>& rows, double lower,
                                     double upper, const GreedyOptions& options,
                                     Progress& progress) {
  LODE_EXPECTS(options.max_error >= 0);
  LODE_EXPECTS(options.order == InsertionOrder::strict ||
               options.max_triangles == std::numeric_limits<std::uint64_t>::max());
  constexpr int kTileBits = 7;  // 128 by 128 samples stay in the cache.
  const LatticePoint size = last_node(mesh);
  std::optional<SparseSamples<T>> sparse;
  if (options.order == InsertionOrder::levels) sparse.emplace(rows, size);
  TriangleJudge<T> judge(rows, sparse ? &*sparse : nullptr, lower, upper, options.max_error,
                         options.observer);
  return GreedyLoop(mesh, judge, options, progress).run(size, kTileBits);
}

template Result<GreedyReport> insert_greedily(LatticeMesh&, const SampleRows<std::int16_t>&, double,
                                              double, const GreedyOptions&, Progress&);
template Result<GreedyReport> insert_greedily(LatticeMesh&, const SampleRows<std::uint16_t>&,
                                              double, double, const GreedyOptions&, Progress&);
template Result<GreedyReport> insert_greedily(LatticeMesh&, const SampleRows<float>&, double,
                                              double, const GreedyOptions&, Progress&);
template Result<GreedyReport> insert_greedily(LatticeMesh&, const SampleRows<double>&, double,
                                              double, const GreedyOptions&, Progress&);

}  // namespace lode::delaunay
