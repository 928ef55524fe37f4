// S. Takahashi, T. Ikeda, Y. Shinagawa, T. L. Kunii, M. Ueda, "Algorithms for extracting correct
// critical points and constructing topological graphs from discrete geographical elevation data",
// Computer Graphics Forum 14 (1995): critical points by the signs round a vertex, the outside a
// virtual pit.
#include "lode/models/terrain/terrain_features/features.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include "lode/core/expects.h"
#include "lode/models/terrain/terrain_features/merge_sweep.h"
#include "lode/models/terrain/terrain_features/vertex_links.h"

namespace lode::terrain_features {
namespace {

constexpr std::uint32_t kVerticesAtOnce = 1U << 16;

/// What a look round each vertex tells.
struct Signs {
  std::vector<std::uint32_t> down;  ///< As MergeSweep takes them.
  std::vector<std::uint32_t> up;
  std::vector<Pass> passes;  ///< Rising.
};

/// Part of it only when cancelled.
Signs find_signs(const VertexLinks& links, Progress& progress) {
  Signs signs;
  signs.down.assign(links.n_vertices(), kNone);
  signs.up.assign(links.n_vertices(), kNone);
  Arcs arcs(links);
  for (std::uint32_t v = 0; v < links.n_vertices(); ++v) {
    if (v % kVerticesAtOnce == 0) {
      if (progress.is_cancelled()) return signs;
      progress.report("critical points", static_cast<double>(v) / links.n_vertices());
    }
    if (!links.has_triangles(v)) continue;
    arcs.look_round(v);
    signs.down[v] = arcs.lowest();
    signs.up[v] = arcs.highest();
    if (arcs.lower().size() > 1)
      signs.passes.push_back({v, static_cast<std::uint32_t>(arcs.lower().size() - 1)});
  }
  std::ranges::sort(signs.passes, [&](const Pass& a, const Pass& b) {
    return links.is_below(a.vertex, b.vertex);
  });
  return signs;
}

/// Each vertex is left at most once, and so no line is longer than there are vertices, nor are all.
class LineTracer {
 public:
  LineTracer(const VertexLinks& links, LineKind kind, const std::vector<std::uint32_t>& next,
             std::vector<FeatureLine>& lines)
      : links_(links), kind_(kind), next_(next), lines_(lines), is_left_(next.size()) {}

  /// From a pass into an arc, whose first node is given.
  void trace(std::uint32_t pass, std::uint32_t arc) {
    if (arc == links_.outside()) return;
    if (next_[arc] == pass) return;  // Whatever is there leaves through the pass.
    if (next_[pass] == arc) {
      if (is_left_[pass]) return;
      is_left_[pass] = true;
    }
    FeatureLine line{kind_, {pass, arc}};
    std::uint32_t at = arc;
    while (!is_left_[at] && next_[at] != at && next_[at] != links_.outside()) {
      is_left_[at] = true;
      at = next_[at];
      line.vertices.push_back(at);
    }
    lines_.push_back(std::move(line));
  }

 private:
  const VertexLinks& links_;
  LineKind kind_;
  const std::vector<std::uint32_t>& next_;
  std::vector<FeatureLine>& lines_;
  std::vector<bool> is_left_;
};

void add_extrema(const MergeSweep& sweep, const VertexLinks& links, CriticalKind kind,
                 Features& features) {
  for (std::size_t e = 0; e < sweep.extrema().size(); ++e) {
    if (sweep.extrema()[e] == links.outside()) continue;
    const bool is_peak = kind == CriticalKind::peak;
    ++(is_peak ? features.all.peaks : features.all.pits);
    if (!sweep.is_kept(e)) continue;
    ++(is_peak ? features.kept.peaks : features.kept.pits);
    features.points.push_back({sweep.extrema()[e], kind, 1, sweep.relief(e)});
  }
}

/// Those kept remain, and what they have without a pair is kept.
void add_passes(std::vector<Pass>& passes, Features& features) {
  for (Pass& pass : passes) {
    features.all.passes += pass.multiplicity;
    if (pass.multiplicity > pass.n_pairs) {  // Between two parts of what is outside.
      pass.n_kept += pass.multiplicity - pass.n_pairs;
      pass.relief = std::numeric_limits<double>::infinity();
    }
    features.kept.passes += pass.n_kept;
    if (pass.n_kept > 0)
      features.points.push_back({pass.vertex, CriticalKind::pass, pass.n_kept, pass.relief});
  }
  std::erase_if(passes, [](const Pass& pass) { return pass.n_kept == 0; });
}

void add_lines(const VertexLinks& links, const MergeSweep& pits, const MergeSweep& peaks,
               std::vector<Pass> passes, Features& features) {
  std::ranges::sort(passes, [](const Pass& a, const Pass& b) {
    return a.relief != b.relief ? a.relief > b.relief : a.vertex < b.vertex;
  });
  LineTracer ridges(links, LineKind::ridge, peaks.next(), features.lines);
  LineTracer channels(links, LineKind::channel, pits.next(), features.lines);
  Arcs arcs(links);
  for (const Pass& pass : passes) {
    arcs.look_round(pass.vertex);
    for (const std::uint32_t arc : arcs.upper()) ridges.trace(pass.vertex, arc);
    for (const std::uint32_t arc : arcs.lower()) channels.trace(pass.vertex, arc);
  }
}

}  // namespace

Result<Features> find_features(const delaunay::Tin& tin, double least_relief, Progress& progress) {
  LODE_EXPECTS(least_relief >= 0);
  const VertexLinks links(tin);
  Signs signs = find_signs(links, progress);
  if (progress.is_cancelled()) return cancelled_error();
  MergeSweep pits(links, SweepFrom::below, std::move(signs.down));
  MergeSweep peaks(links, SweepFrom::above, std::move(signs.up));
  for (MergeSweep* sweep : {&pits, &peaks}) {
    sweep->pair_extrema(signs.passes, least_relief, progress);
    if (progress.is_cancelled()) return cancelled_error();
    sweep->reroute();
  }
  Features features;
  features.euler_number = links.euler_number();
  add_extrema(pits, links, CriticalKind::pit, features);
  add_extrema(peaks, links, CriticalKind::peak, features);
  add_passes(signs.passes, features);
  std::ranges::sort(features.points, {}, &CriticalPoint::vertex);
  progress.report("ridges and channels", 0);
  add_lines(links, pits, peaks, std::move(signs.passes), features);
  return features;
}

}  // namespace lode::terrain_features
