#include "bench/tetra_surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "bench/peers/linear_contour.h"
#include "lode/api/tetra_dataset.h"
#include "lode/mappers/mesh_gradients.h"
#include "lode/mappers/mesh_isosurface.h"
#include "tests/oracles/tetra_surfaces.h"

namespace lode::bench {
namespace {

constexpr Threads kThreads{2};
constexpr const char* kPeer = "vtkContour3DLinearGrid";

double middle_of(const TetraMesh& mesh) {
  const auto [low, high] = std::ranges::minmax(mesh.fields.front().values);
  return (low + high) / 2;
}

Result<Seconds> time_ours(const SimplexMesh& mesh, double isovalue,
                          const MeshIsosurfaceOptions& options, Surface& surface) {
  MeshIsosurfaceOptions all = options;
  return time_runs("isosurface", [&]() -> Result<void> {
    surface = {};
    all.margin = rounding_margin(mesh.positions, {});
    add_isosurface(mesh, isovalue, all, surface);
    return {};
  });
}

Row versus(std::string name, const Seconds& ours, const Surface& surface, const Seconds& theirs,
           const PeerCounts& counts, std::string note) {
  return {.name = std::move(name),
          .ours_s = ours.median,
          .peer = kPeer,
          .peer_s = theirs.median,
          .ours_fastest_s = ours.fastest,
          .peer_fastest_s = theirs.fastest,
          .counts = {{"ours_triangles", static_cast<double>(surface.triangles.size())},
                     {"peer_triangles", static_cast<double>(counts.triangles)},
                     {"ours_vertices", static_cast<double>(surface.positions.size())},
                     {"peer_vertices", static_cast<double>(counts.vertices)}},
          .note = std::move(note)};
}

/// The same surface from the cut that keeps it: what that takes of the share of cells it has.
Result<void> time_cut(const std::string& name, const TetraMesh& mesh, const Surface& full,
                      const Seconds& full_seconds, Table& table) {
  Progress progress;
  LODE_TRY(const TetraDataset dataset, TetraDataset::build(mesh, {.threads = kThreads}, progress));
  TetraMeshOptions options;
  options.query.isovalues = {middle_of(mesh)};
  options.query.max_error = 0;
  SimplexMesh cut;
  LODE_CHECK(dataset.extract_mesh(options, cut, progress));
  Surface surface;
  LODE_TRY(const Seconds seconds, time_ours(cut, middle_of(mesh), {.threads = kThreads}, surface));
  if (oracles::sorted_triangles(surface) != oracles::sorted_triangles(full))
    return fail("{}: expected the cut's isosurface to be the mesh's, got another", name);
  const double share =
      static_cast<double>(cut.n_cells()) / static_cast<double>(mesh.tetrahedra.size());
  const double cost = seconds.median / full_seconds.median;
  table.add({.name = "isosurface_of_cut/" + name,
             .ours_s = seconds.median,
             .peer = {},
             .peer_s = {},
             .ours_fastest_s = seconds.fastest,
             .peer_fastest_s = {},
             .counts = {{"ours_triangles", static_cast<double>(surface.triangles.size())},
                        {"share_of_cells", share},
                        {"share_of_time", cost}},
             .note = fmt::format("the same triangles from {:.1f} % of the cells in {:.1f} % of the "
                                 "time: {:.2f} of what they come to",
                                 100 * share, 100 * cost, cost / share)});
  return {};
}

/// With normals, from gradients that are there; VTK takes them from the triangles.
Result<void> race_normals(const std::string& name, const SimplexMesh& mesh, double isovalue,
                          LinearContour& peer, Table& table) {
  std::vector<Vec3f> gradients;
  LODE_TRY(const Seconds preparing, time_runs("gradients", [&]() -> Result<void> {
             gradients = vertex_gradients(mesh, kThreads);
             return {};
           }));
  Surface surface;
  PeerCounts counts;
  LODE_TRY(const Seconds ours,
           time_ours(mesh, isovalue, {.gradients = gradients, .threads = kThreads}, surface));
  LODE_TRY(const Seconds theirs, time_runs("contour", [&]() -> Result<void> {
             LODE_TRY(counts, peer.extract(isovalue, PeerVertices::shared, PeerNormals::on));
             return {};
           }));
  table.add(versus("isosurface/" + name + "/normals", ours, surface, theirs, counts,
                   fmt::format("ours of gradients found before in {:.0f} ms, VTK's of triangles",
                               1e3 * preparing.median)));
  return {};
}

}  // namespace

Result<void> race_isosurfaces(const std::string& name, const TetraMesh& mesh, Table& table) {
  const SimplexMesh cells = oracles::to_simplex_mesh(mesh);
  const double isovalue = middle_of(mesh);
  LinearContour peer(mesh);
  PeerCounts counts;
  const auto time_peer = [&](PeerVertices vertices) {
    return time_runs("contour", [&]() -> Result<void> {
      LODE_TRY(counts, peer.extract(isovalue, vertices, PeerNormals::off));
      return {};
    });
  };
  Surface surface;
  LODE_TRY(const Seconds narrow, time_ours(cells, isovalue, {.threads = {1}}, surface));
  LODE_TRY(const Seconds ours, time_ours(cells, isovalue, {.threads = kThreads}, surface));
  LODE_TRY(const Seconds theirs_apart, time_peer(PeerVertices::apart));
  const PeerCounts counts_apart = counts;
  LODE_TRY(const Seconds theirs, time_peer(PeerVertices::shared));
  table.add(versus("isosurface/" + name, ours, surface, theirs, counts, "a vertex an edge"));
  table.add(versus("isosurface/" + name + "/1_thread", narrow, surface, theirs, counts,
                   "ours with one thread"));
  table.add(versus("isosurface/" + name + "/vtk_apart", ours, surface, theirs_apart, counts_apart,
                   "VTK's vertices are not shared, as it has them unless told otherwise"));
  LODE_CHECK(race_normals(name, cells, isovalue, peer, table));
  return time_cut(name, mesh, surface, ours, table);
}

}  // namespace lode::bench
