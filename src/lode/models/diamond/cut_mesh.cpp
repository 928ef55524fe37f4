#include "lode/models/diamond/cut_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lode/mappers/lattice_key.h"
#include "lode/mappers/vertex_ids.h"
#include "lode/models/diamond/barycentric.h"
#include "lode/models/diamond/border_clip.h"
#include "lode/models/diamond/paged_refinable.h"

namespace lode::diamond {
namespace {

/// Which of a simplex's finest ones there are.
struct Presence {
  bool has_present = false;
  bool has_removed = false;

  [[nodiscard]] bool is_mixed() const { return has_present && has_removed; }
};

template <int D, typename Field>
void find_presence(const Field& model, const Simplex<D>& s, Presence& presence) {
  const LatticeBox<D> box = bounds_of(s);
  if (presence.is_mixed() || !model.shape.overlaps_data(box)) return;
  if (is_finest(s)) {
    (model.is_removed_cell(box.lower) ? presence.has_removed : presence.has_present) = true;
    return;
  }
  for (const Simplex<D>& half : bisect(s)) find_presence<D>(model, half, presence);
}

template <int D, typename Field>
class MeshBuilder {
 public:
  MeshBuilder(const Refinable<D, Field>& opened, const CutMeshOptions& options, SimplexMesh& mesh)
      : opened_(opened),
        model_(opened.model()),
        options_(options),
        mesh_(mesh),
        clip_(model_.shape.dims),
        is_mirrored_(determinant(model_.info.grid.index_to_world_matrix()) < 0),
        whole_range_(std::nextafter(model_.stats.max - model_.stats.min,
                                    std::numeric_limits<double>::infinity())) {
    mesh_.positions.clear();
    mesh_.values.clear();
    mesh_.tetrahedra.clear();
    mesh_.triangles.clear();
    mesh_.errors.clear();
    mesh_.has_narrow_values = true;
    cells().reserve(options.n_expected);
    mesh_.errors.reserve(options.n_expected);
  }

  void add(const Simplex<D>& s);
  /// Whether a simplex is near what is asked for.
  [[nodiscard]] bool is_near(const Simplex<D>& s) const;
  [[nodiscard]] const CutMeshReport& report() const { return report_; }
  [[nodiscard]] bool is_full() const { return is_full_; }

 private:
  using Piece = typename BorderClip<D>::Piece;
  struct Bound {
    double error = 0;
    bool is_in_focus = true;
  };

  [[nodiscard]] auto& cells() {
    if constexpr (D == 3)
      return mesh_.tetrahedra;
    else
      return mesh_.triangles;
  }
  [[nodiscard]] Vec3d world(const Index<D>& p) const {
    const Index3 q = model_.axes.to_grid(p);
    return model_.info.grid.to_world({{double(q[0]), double(q[1]), double(q[2])}});
  }
  [[nodiscard]] Bound bound_of(const Simplex<D>& s) const;
  [[nodiscard]] bool exists(const Simplex<D>& s, double error);
  [[nodiscard]] double interpolated(const Simplex<D>& s, const Index<D>& p) const;
  std::uint32_t vertex_at(const Simplex<D>& s, const Index<D>& p);

  const Refinable<D, Field>& opened_;
  const Field& model_;
  const CutMeshOptions& options_;
  SimplexMesh& mesh_;
  BorderClip<D> clip_;
  bool is_mirrored_;
  double whole_range_;  ///< No F' is further from F.
  VertexIds ids_;
  std::array<double, as_size(D) + 1> corner_{};  ///< Values of the simplex being added.
  CutMeshReport report_;
  bool is_full_ = false;
};

template <int D, typename Field>
bool MeshBuilder<D, Field>::is_near(const Simplex<D>& s) const {
  if (!options_.is_near) return true;
  std::array<Vec3d, as_size(D) + 1> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = world(s.v[i]);
  return options_.is_near(corners);
}

template <int D, typename Field>
auto MeshBuilder<D, Field>::bound_of(const Simplex<D>& s) const -> Bound {
  if (is_finest(s)) return {};
  const NodeFacts facts = facts_of(opened_, id_of<D>(s.bisection_point()));
  return {facts.error, options_.focus.touches(facts)};
}

/// Only where holes are near can a stored error be infinite.
template <int D, typename Field>
bool MeshBuilder<D, Field>::exists(const Simplex<D>& s, double error) {
  if (!model_.has_holes()) return true;
  if (std::isinf(error)) {
    Presence presence;
    find_presence<D>(model_, s, presence);
    if (!presence.has_present) return false;
    report_.n_left_out += presence.has_removed ? 1 : 0;
    if (presence.has_removed) return false;
  } else if (model_.is_removed(s)) {
    return false;
  }
  // A corner beyond the data may have the value of a hole.
  if (std::none_of(corner_.begin(), corner_.end(), [](double f) { return std::isnan(f); }))
    return true;
  ++report_.n_left_out;
  return false;
}

/// F' at a lattice point: the weights are exact, and added in an order that is the same in all
/// simplices that share the point.
template <int D, typename Field>
double MeshBuilder<D, Field>::interpolated(const Simplex<D>& s, const Index<D>& p) const {
  const Barycentric<D> coordinates(s);
  std::array<std::int64_t, as_size(D) + 1> weights{};
  const bool is_inside = coordinates.weights(p, weights);
  LODE_EXPECTS(is_inside);
  std::array<std::size_t, as_size(D) + 1> order{};
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(),
            [&](std::size_t i, std::size_t j) { return s.v[i] < s.v[j]; });
  double value = 0;
  for (const std::size_t i : order)
    if (weights[i] != 0)
      value += static_cast<double>(weights[i]) / static_cast<double>(coordinates.weight_sum()) *
               corner_[i];
  return value;
}

template <int D, typename Field>
std::uint32_t MeshBuilder<D, Field>::vertex_at(const Simplex<D>& s, const Index<D>& p) {
  const auto [id, is_new] = ids_.find_or_add(to_key(model_.axes.to_grid(p)));
  if (!is_new) return id;
  is_full_ = is_full_ || id == 0xFFFFFFFEU;
  const auto corner = static_cast<std::size_t>(std::find(s.v.begin(), s.v.end(), p) - s.v.begin());
  const double value = corner < s.v.size() ? corner_[corner] : interpolated(s, p);
  mesh_.positions.push_back(world(p));
  mesh_.values.push_back(value);
  mesh_.has_narrow_values =
      mesh_.has_narrow_values && static_cast<double>(static_cast<float>(value)) == value;
  return id;
}

template <int D, typename Field>
void MeshBuilder<D, Field>::add(const Simplex<D>& s) {
  const std::span<const Piece> pieces = clip_.clip(s);
  if (pieces.empty() || is_full_) return;
  for (std::size_t i = 0; i < corner_.size(); ++i) corner_[i] = model_.value_or_nan(s.v[i]);
  const Bound bound = bound_of(s);
  if (options_.only_focus && !bound.is_in_focus) return;
  if (!exists(s, bound.error)) return;
  for (const Piece& piece : pieces) {
    auto& cell = cells().emplace_back();
    for (std::size_t i = 0; i < piece.size(); ++i) cell[i] = vertex_at(s, piece[i]);
    if (is_mirrored_) std::swap(cell[0], cell[1]);
  }
  const float error = float_up(std::min(bound.error, whole_range_));
  mesh_.errors.insert(mesh_.errors.end(), pieces.size(), error);
  report_.largest_error = std::max(report_.largest_error, static_cast<double>(error));
  if (bound.is_in_focus)
    report_.achieved_error = std::max(report_.achieved_error, static_cast<double>(error));
}

}  // namespace

template <int D, typename Field>
Result<CutMeshReport> mesh_of_cut(const Refinable<D, Field>& opened, const Cut& cut,
                                  const CutMeshOptions& options, SimplexMesh& mesh,
                                  Progress& progress) {
  constexpr std::uint64_t kLeavesPerReport = 1 << 16;
  MeshBuilder<D, Field> builder(opened, options, mesh);
  std::uint64_t n_done = 0;
  bool is_stopped = false;
  opened.for_each_leaf(
      cut, [&](const Simplex<D>& s) { return !is_stopped && builder.is_near(s); },
      [&](const Simplex<D>& s) {
        builder.add(s);
        if (++n_done % kLeavesPerReport != 0) return;
        is_stopped = progress.is_cancelled() || builder.is_full();
        if (options.n_expected > 0)
          progress.report("meshing", std::min(1.0, static_cast<double>(n_done) /
                                                       static_cast<double>(options.n_expected)));
      });
  if (progress.is_cancelled()) return cancelled_error();
  if (builder.is_full()) return fail("expected a mesh of fewer than 2^32 - 1 vertices, got more");
  return builder.report();
}

template Result<CutMeshReport> mesh_of_cut<2>(const Refinable<2>&, const Cut&,
                                              const CutMeshOptions&, SimplexMesh&, Progress&);
template Result<CutMeshReport> mesh_of_cut<3>(const Refinable<3>&, const Cut&,
                                              const CutMeshOptions&, SimplexMesh&, Progress&);
template Result<CutMeshReport> mesh_of_cut<2>(const Refinable<2, PagedModel<2>>&, const Cut&,
                                              const CutMeshOptions&, SimplexMesh&, Progress&);
template Result<CutMeshReport> mesh_of_cut<3>(const Refinable<3, PagedModel<3>>&, const Cut&,
                                              const CutMeshOptions&, SimplexMesh&, Progress&);

}  // namespace lode::diamond
