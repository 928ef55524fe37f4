// Meshes of tetrahedra: isosurfaces, with VTK's threaded filter in the same run; edge collapses and
// the hierarchy made of them, with VTK's quadric decimation to as many cells in the same run. Both
// start from memory; ours has two threads where a row does not say one, VTK's filter has one.
// Errors of both are found by one search.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/peers/flying_edges.h"
#include "bench/peers/quadric_decimation.h"
#include "bench/report.h"
#include "bench/tetra_cases.h"
#include "bench/tetra_errors.h"
#include "bench/tetra_surfaces.h"
#include "lode/core/stopwatch.h"
#include "lode/models/tetra_mt/everywhere_errors.h"
#include "lode/models/tetra_mt/half_edge.h"
#include "lode/models/tetra_mt/hierarchy.h"
#include "lode/models/tetra_mt/tetra_cut.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::bench {
namespace {

using tetra_mt::CollapseOrder;
using tetra_mt::HalfEdgeCollapses;
using tetra_mt::Hierarchy;
using tetra_mt::PackedHierarchy;
using tetra_mt::TetraCut;

constexpr Threads kThreads{2};
constexpr int kRuns = 5;
constexpr const char* kPeer = "vtkUnstructuredGridQuadricDecimation";
constexpr std::array<double, 2> kShares{0.10, 0.05};  ///< Of the cells, to collapse to.
constexpr double kBaseShare = 0.01;
constexpr std::uint64_t kNoiseSeed = 1;
constexpr std::array<std::pair<CollapseOrder, const char*>, 2> kOtherOrders{
    {{CollapseOrder::quadric, "quadric"}, {CollapseOrder::space_error, "space"}}};

struct Settings {
  std::string only;          ///< Only cases whose name contains this.
  bool is_surfaces = false;  ///< Nothing but isosurfaces.
  bool is_refining = false;  ///< Nothing but refining.
  std::string json_path;
};

struct Timed {
  Seconds seconds;
  std::uint64_t cells = 0;
  FieldErrors errors;
};

std::vector<TetraCase> tetra_cases() {
  std::vector<TetraCase> cases = real_tetra_cases();
  cases.insert(cases.begin(), noise_case(oracles::Cut::in_five));
  return cases;
}

double part_of(const TetraMesh& mesh, double share) {
  return share * static_cast<double>(mesh.tetrahedra.size());
}

TetraField field_of(const TetraMesh& mesh, const std::vector<tetra_mt::Tetrahedron>& tetrahedra) {
  return {mesh.positions, mesh.fields.front().values, tetrahedra};
}

struct Collapsing {
  double share = kBaseShare;  ///< Of the cells, to collapse to.
  Threads threads = kThreads;
  CollapseOrder order = CollapseOrder::squared_error;
};

Result<HalfEdgeCollapses> collapse(const TetraMesh& mesh, const Collapsing& how) {
  Progress progress;
  return tetra_mt::collapse_half_edges(
      mesh,
      {.base_cells = static_cast<std::uint64_t>(part_of(mesh, how.share)),
       .rules = {.order = how.order},
       .threads = how.threads},
      progress);
}

Result<Timed> time_collapse(const TetraMesh& mesh, const Collapsing& how) {
  Timed timed;
  std::optional<HalfEdgeCollapses> collapses;
  LODE_TRY(timed.seconds, time_runs(
                              "collapse",
                              [&]() -> Result<void> {
                                collapses.reset();
                                LODE_TRY(collapses, collapse(mesh, how));
                                return {};
                              },
                              kRuns));
  timed.cells = collapses->base.size();
  timed.errors = measure_errors(mesh, field_of(mesh, collapses->base), kThreads);
  return timed;
}

Result<Timed> time_peer(const TetraMesh& mesh, QuadricDecimation& peer, std::uint64_t n_cells) {
  Timed timed;
  LODE_TRY(timed.seconds, time_runs(
                              "decimate",
                              [&]() -> Result<void> {
                                LODE_TRY(timed.cells, peer.decimate(n_cells));
                                return {};
                              },
                              kRuns));
  const TetraMesh left = peer.mesh();
  timed.errors = measure_errors(mesh, field_of(left, left.tetrahedra), kThreads);
  return timed;
}

Row versus(std::string name, const Timed& ours, const Timed& theirs, std::string note) {
  return {.name = std::move(name),
          .ours_s = ours.seconds.median,
          .peer = kPeer,
          .peer_s = theirs.seconds.median,
          .ours_fastest_s = ours.seconds.fastest,
          .peer_fastest_s = theirs.seconds.fastest,
          .counts = {{"ours_cells", static_cast<double>(ours.cells)},
                     {"peer_cells", static_cast<double>(theirs.cells)},
                     {"ours_max_error", ours.errors.max},
                     {"peer_max_error", theirs.errors.max},
                     {"ours_rms_error", ours.errors.rms},
                     {"peer_rms_error", theirs.errors.rms},
                     {"ours_farthest", ours.errors.farthest},
                     {"peer_farthest", theirs.errors.farthest}},
          .note = std::move(note)};
}

Row alone(std::string name, const Seconds& seconds, std::map<std::string, double> counts,
          std::string note) {
  return {.name = std::move(name),
          .ours_s = seconds.median,
          .peer = {},
          .peer_s = {},
          .ours_fastest_s = seconds.fastest,
          .peer_fastest_s = {},
          .counts = std::move(counts),
          .note = std::move(note)};
}

std::string describe(const FieldErrors& errors) {
  return fmt::format("max {:.4g} rms {:.4g} farthest outside {:.2g}", errors.max, errors.rms,
                     errors.farthest);
}

/// Collapses to a share of the cells, and decimation to as many: what the latter took.
Result<Timed> run_collapse(const TetraCase& tetra_case, const TetraMesh& mesh, double share,
                           QuadricDecimation& peer, Table& table) {
  const std::string name = fmt::format("{}/{:g}%", tetra_case.name, 100 * share);
  LODE_TRY(const Timed ours, time_collapse(mesh, {.share = share}));
  LODE_TRY(const Timed theirs, time_peer(mesh, peer, ours.cells));
  std::string note = fmt::format("field errors at all vertices: ours {}; theirs {}",
                                 describe(ours.errors), describe(theirs.errors));
  // It ends where it finds no more edges that it may collapse.
  if (theirs.cells > ours.cells + ours.cells / 10) note += "; theirs stopped early: not as small";
  table.add(versus("collapse/" + name, ours, theirs, note));
  for (const auto& [order, order_name] : kOtherOrders) {
    LODE_TRY(const Timed other, time_collapse(mesh, {.share = share, .order = order}));
    table.add(versus(fmt::format("collapse/{}/{}", name, order_name), other, theirs,
                     describe(other.errors)));
  }
  if (share < kShares.front()) return theirs;
  LODE_TRY(const Timed narrow, time_collapse(mesh, {.share = share, .threads = {1}}));
  table.add(versus("collapse/" + name + "/1_thread", narrow, theirs, "ours with one thread too"));
  return theirs;
}

struct Made {
  Hierarchy hierarchy;
  PackedHierarchy packed;
};

Result<Made> make(const TetraMesh& mesh) {
  LODE_TRY(const HalfEdgeCollapses collapses, collapse(mesh, {}));
  LODE_TRY(Hierarchy hierarchy, make_hierarchy(mesh, collapses, kThreads));
  PackedHierarchy packed = PackedHierarchy::pack(hierarchy, mesh.tetrahedra.size(), kThreads);
  return Made{std::move(hierarchy), std::move(packed)};
}

/// All of ours from a mesh to its hierarchy, against what the peer takes to simplify it once.
Result<Made> run_hierarchy(const TetraCase& tetra_case, const TetraMesh& mesh, const Timed& peer,
                           Table& table) {
  Timed ours;
  std::optional<Made> made;
  const Work work = [&]() -> Result<void> {
    made.reset();
    LODE_TRY(made, make(mesh));
    return {};
  };
  LODE_TRY(ours.seconds, time_runs("hierarchy", work, kRuns));
  ours.cells = made->hierarchy.n_base_cells;
  std::vector<tetra_mt::Tetrahedron> base = TetraCut(made->packed).cells();
  ours.errors = measure_errors(
      mesh, {made->hierarchy.positions, made->hierarchy.fields.front().values, base}, kThreads);
  const double n = made->hierarchy.n_nodes();
  const double arcs = static_cast<double>(made->hierarchy.children.size()) / n;
  const double bytes = static_cast<double>(made->packed.n_page_bytes()) / n;
  Row row = versus("hierarchy/" + tetra_case.name, ours, peer,
                   fmt::format("{} nodes, {:.2f} arcs and {:.1f} bytes a node; base: {}",
                               made->hierarchy.n_nodes(), arcs, bytes, describe(ours.errors)));
  row.counts["nodes"] = n;
  row.counts["arcs_per_node"] = arcs;
  row.counts["bytes_per_node"] = bytes;
  table.add(std::move(row));
  return std::move(*made);
}

/// That errors hold everywhere, not at samples alone.
Result<void> run_everywhere(const TetraCase& tetra_case, const TetraMesh& mesh, const Timed& peer,
                            Table& table) {
  LODE_TRY(const HalfEdgeCollapses collapses, collapse(mesh, {}));
  tetra_mt::EverywhereReport report;
  const Work work = [&]() -> Result<void> {
    HalfEdgeCollapses copy = collapses;
    Progress progress;
    LODE_TRY(report, make_errors_hold_everywhere(mesh, copy, kThreads, progress));
    return {};
  };
  Timed ours;
  LODE_TRY(ours.seconds, time_runs("everywhere", work, kRuns));
  table.add({.name = "everywhere/" + tetra_case.name,
             .ours_s = ours.seconds.median,
             .peer = kPeer,
             .peer_s = peer.seconds.median,
             .ours_fastest_s = ours.seconds.fastest,
             .peer_fastest_s = peer.seconds.fastest,
             .counts = {{"faces", static_cast<double>(report.n_faces)}},
             .note = fmt::format("the pass alone: {} faces, against what the peer takes to "
                                 "decimate to a twentieth",
                                 report.n_faces)});
  return {};
}

/// All nodes applied and undone again.
Result<void> run_refine(const TetraCase& tetra_case, const Made& made, Table& table) {
  TetraCut cut(made.packed);
  const std::vector<std::uint32_t>& order = made.hierarchy.order;
  const Work work = [&]() -> Result<void> {
    for (const std::uint32_t node : order) cut.apply(NodeId{node});
    for (std::size_t k = order.size(); k-- > 0;) cut.undo(NodeId{order[k]});
    return {};
  };
  LODE_TRY(const Seconds seconds, time_runs("refine", work, kRuns));
  const double updates = 2.0 * static_cast<double>(order.size());
  table.add(alone("refine/" + tetra_case.name, seconds,
                  {{"updates", updates}, {"updates_per_s", updates / seconds.median}},
                  fmt::format("one thread: {:.2f} M updates/s, fastest {:.2f}",
                              updates / seconds.median / 1e6, updates / seconds.fastest / 1e6)));
  return {};
}

/// An isosurface at the middle of the range, from the base.
void run_isovalue(const TetraCase& tetra_case, const TetraMesh& mesh,
                  const PackedHierarchy& hierarchy, double tolerance_share, Table& table) {
  const auto [low, high] = std::ranges::minmax(mesh.fields.front().values);
  const Demand demand = isovalue_demand((low + high) / 2, tolerance_share * (high - low));
  std::vector<double> seconds;
  Standing standing;
  for (int run = 0; run <= kRuns; ++run) {
    TetraCut cut(hierarchy);
    Engine<TetraCut> engine(cut);
    const Stopwatch stopwatch;
    engine.set_query(demand, {}, FocusChange::changed, ApplyOrder::nearest_first);
    engine.finish();
    if (run > 0) seconds.push_back(stopwatch.seconds());
    standing = engine.standing();
  }
  std::ranges::sort(seconds);
  const auto cells = static_cast<double>(standing.n_cells);
  const double share = cells / part_of(mesh, 1);
  table.add(
      alone(fmt::format("isovalue/{}/{:g}%", tetra_case.name, 100 * tolerance_share),
            {seconds[seconds.size() / 2], seconds.front()},
            {{"ours_cells", cells}, {"share_of_cells", share}},
            fmt::format("one thread, from the base: {} nodes, {:.1f} % of the cells, error bound "
                        "{:.3g}",
                        standing.n_applied, 100 * share, standing.error_bound)));
}

Result<void> run_refining(const TetraCase& tetra_case, const TetraMesh& mesh, const Made& made,
                          Table& table) {
  LODE_CHECK(run_refine(tetra_case, made, table));
  for (const double tolerance : {0.0, 0.02})
    run_isovalue(tetra_case, mesh, made.packed, tolerance, table);
  return {};
}

Result<void> run_case(const TetraCase& tetra_case, const Settings& settings, Table& table) {
  LODE_TRY(const TetraMesh mesh, load(tetra_case));
  const auto [low, high] = std::ranges::minmax(mesh.fields.front().values);
  fmt::print("{}: {} tetrahedra, {} vertices, values {:.4g} to {:.4g}\n", tetra_case.name,
             mesh.tetrahedra.size(), mesh.positions.size(), low, high);
  if (settings.is_refining) {
    LODE_TRY(const Made made, make(mesh));
    return run_refining(tetra_case, mesh, made, table);
  }
  LODE_CHECK(race_isosurfaces(tetra_case.name, mesh, table));
  if (settings.is_surfaces) return {};
  QuadricDecimation peer(mesh);
  LODE_CHECK(run_collapse(tetra_case, mesh, kShares[0], peer, table));
  LODE_TRY(const Timed theirs, run_collapse(tetra_case, mesh, kShares[1], peer, table));
  LODE_TRY(const Made made, run_hierarchy(tetra_case, mesh, theirs, table));
  LODE_CHECK(run_everywhere(tetra_case, mesh, theirs, table));
  return run_refining(tetra_case, mesh, made, table);
}

/// On a simplified mesh, as it is used.
Result<void> check_errors() {
  const TetraMesh mesh = oracles::noise_mesh(9, oracles::Cut::in_five, kNoiseSeed);
  LODE_TRY(const HalfEdgeCollapses collapses, collapse(mesh, {.share = 0.3}));
  LODE_CHECK(check_locator(field_of(mesh, mesh.tetrahedra)));
  return check_locator(field_of(mesh, collapses.base));
}

int run(const Settings& settings) {
  if (auto checked = check_errors(); !checked) {
    fmt::print(stderr, "tetra_bench: errors are not measured well: {}\n", checked.error().message);
    return 1;
  }
  print_heading(describe_peer() + " (decimation: one)", kRuns, Counted::cells);
  Table table;
  for (const TetraCase& tetra_case : tetra_cases()) {
    if (tetra_case.name.find(settings.only) == std::string::npos) continue;
    if (auto done = run_case(tetra_case, settings, table); !done)
      table.add({.name = tetra_case.name, .note = done.error().message});
  }
  return write_table(table, "tetra_bench", settings.json_path);
}

}  // namespace
}  // namespace lode::bench

int main(int argc, char** argv) {
  lode::bench::keep_freed_memory();
  CLI::App app("Times simplifying meshes of tetrahedra against VTK, and refining them.");
  lode::bench::Settings settings;
  app.add_option("--only", settings.only, "Only cases whose name contains this");
  app.add_flag("--surfaces", settings.is_surfaces, "Isosurfaces alone");
  app.add_flag("--refining", settings.is_refining, "Refining alone");
  app.add_option("--json", settings.json_path, "Also write the rows to this file");
  CLI11_PARSE(app, argc, argv);
  return lode::bench::run(settings);
}
