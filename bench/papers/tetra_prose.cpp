#include "bench/papers/tetra_prose.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "bench/timing.h"
#include "lode/core/box.h"
#include "lode/core/progress.h"
#include "lode/models/tetra_mt/file_layout.h"
#include "lode/models/tetra_mt/tetra_cut.h"
#include "lode/refine/budget.h"
#include "lode/refine/counted_cut.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"
#include "lode/store/reader.h"

namespace lode::bench {
namespace {

using tetra_mt::PackedHierarchy;
using tetra_mt::TetraCut;

constexpr std::uint64_t kPaperBudget = 40'000;  ///< Figure 10's.

/// A question of figures 7 to 10, and the same a little further on.
struct PlaceQuery {
  std::string name;
  FocusDemand first;
  FocusDemand moved;
  Budget budget{};
};

struct Answers {
  std::uint64_t n_cells = 0;  ///< Of the first.
  double reached = 0;         ///< Error in focus.
  std::uint64_t n_updates = 0;
  std::uint64_t n_moved = 0;
  std::vector<double> seconds{};  ///< One a run.
  std::vector<double> moved_seconds{};
};

void ask(const PackedHierarchy& hierarchy, const PlaceQuery& query, Answers& answers) {
  CountedCut<TetraCut> cut(hierarchy);
  Engine<CountedCut<TetraCut>> engine(cut);
  const auto refine = [&](const FocusDemand& demand) {
    const auto start = Clock::now();
    engine.set_query(Demand(demand), query.budget, FocusChange::changed, ApplyOrder::nearest_first);
    engine.finish();
    return seconds_since(start);
  };
  answers.seconds.push_back(refine(query.first));
  answers.n_cells = engine.n_cells();
  answers.n_updates = cut.n_updates();
  answers.reached = engine.largest([&](const NodeFacts& node) { return query.first.error(node); });
  answers.moved_seconds.push_back(refine(query.moved));
  answers.n_moved = cut.n_updates() - answers.n_updates;
}

/// From one quantile of the vertices to another, axis by axis.
Box3d quantile_box(const TetraMesh& mesh, double from, double to) {
  std::array<double, 3> lower{};
  std::array<double, 3> upper{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> places;
    places.reserve(mesh.positions.size());
    for (const auto& position : mesh.positions) places.push_back(position[axis]);
    std::ranges::sort(places);
    const auto last = static_cast<double>(places.size() - 1);
    lower[axis] = places[static_cast<std::size_t>(from * last)];
    upper[axis] = places[static_cast<std::size_t>(to * last)];
  }
  return {Vec3d{lower}, Vec3d{upper}};
}

Box3d moved(Box3d box, double x) {
  box.lower[0] += x;
  box.upper[0] += x;
  return box;
}

/// Figure 7: two isosurfaces, then one of them a little further on.
PlaceQuery two_isovalues(const TetraData& data) {
  const auto demand = [&](double upper) {
    return FocusDemand{
        .foci = {IsovalueFocus{{data.low + data.range() / 10, data.low + upper * data.range()}}},
        .ends_at_border = true};
  };
  return {"isovalues of 10 and 90 % of the range", demand(0.9), demand(0.905)};
}

/// Figures 8 and 9: what is between the quantiles of 30 and 70 % on each axis, moved by a tenth of
/// its width.
PlaceQuery box_query(const TetraData& data, double tolerance) {
  const Box3d box = quantile_box(data.mesh, 0.3, 0.7);
  const double step = (box.upper[0] - box.lower[0]) / 10;
  return {"box, moved by a tenth of its width",
          {.foci = {BoxFocus{box}}, .inside = tolerance},
          {.foci = {BoxFocus{moved(box, step)}}, .inside = tolerance}};
}

/// Figure 10: across the middle of the longest axis, moved by a hundredth of that.
PlaceQuery plane_query(const TetraData& data, Budget budget) {
  const Box3d box = quantile_box(data.mesh, 0, 1);
  const Vec3d size = box.upper - box.lower;
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (size[k] > size[axis]) axis = k;
  SectionFocus section{0.5 * (box.lower + box.upper), {}};
  section.normal[axis] = 1;
  SectionFocus next = section;
  next.point[axis] += 0.01 * size[axis];
  const double tolerance = 0.02 * data.range();
  return {budget.is_limited() ? fmt::format("plane, at most {} tetrahedra", budget.max_cells)
                              : "plane, moved by a hundredth of the domain",
          {.foci = {section}, .inside = tolerance},
          {.foci = {next}, .inside = tolerance},
          budget};
}

/// Bytes of a file's blocks, of two kinds left out.
std::uint64_t bare_bytes(const store::Reader& reader) {
  std::uint64_t n = 0;
  for (const store::BlockEntry& block : reader.blocks()) {
    const auto kind = static_cast<tetra_mt::Kind>(block.key.kind);
    if (kind != tetra_mt::Kind::gradients && kind != tetra_mt::Kind::mesh_vertices)
      n += block.stored_size;
  }
  return n;
}

/// Of pages, and of what the base takes beside them.
std::size_t memory_bytes(const PackedHierarchy& hierarchy) {
  const tetra_mt::HierarchyHead& head = hierarchy.head();
  constexpr std::size_t kBaseVertex = 3 * 8 + 8;  // position and value
  constexpr std::size_t kBaseCell = 4 * 4 + 4;    // corners and what replaces it
  return hierarchy.n_page_bytes() + kBaseVertex * head.base_positions.size() +
         kBaseCell * head.base.size() + 4 * head.base_regions.size() + 4 * head.roots.size();
}

struct FileSizes {
  std::uint64_t all;
  std::uint64_t bare;
};

Result<FileSizes> file_sizes(const TetraData& data, Placement placement) {
  const std::string path = (std::filesystem::temp_directory_path() /
                            fmt::format("lode_tetra_tables_{}.lode", ::getpid()))
                               .string();
  Progress progress;
  const auto written = TetraDataset::build_file(
      data.mesh, path,
      {.base_share = kTableBaseShare, .placement = placement, .threads = kTableThreads}, progress);
  FileSizes sizes{};
  if (written) {
    const auto reader = store::Reader::open(path);
    if (reader) sizes = {written->file_bytes, bare_bytes(*reader)};
  }
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
  if (!written) return written.error();
  if (sizes.all == 0) return fail("{}: cannot be read again", path);
  return sizes;
}

}  // namespace

Result<void> TetraProse::add_storage(const TetraData& data) {
  const auto n = static_cast<double>(data.mesh.positions.size());
  const auto a_vertex = [&](auto bytes) {
    return fmt::format("{:.1f}", static_cast<double>(bytes) / n);
  };
  const std::size_t mesh_bytes = 32 * data.mesh.tetrahedra.size() + 16 * data.mesh.positions.size();
  const std::size_t memory = memory_bytes(data.hierarchy);
  LODE_TRY(const FileSizes half_edges, file_sizes(data, Placement::half_edge));
  LODE_TRY(const FileSizes midpoints, file_sizes(data, Placement::midpoint));
  storage_.rows.push_back(
      {data.name, a_vertex(mesh_bytes),
       fmt::format("{:.1f}", static_cast<double>(data.hierarchy.n_page_bytes()) /
                                 data.hierarchy.head().shape.n_nodes),
       a_vertex(memory),
       fmt::format("{:.1f}", static_cast<double>(mesh_bytes) / static_cast<double>(memory)),
       a_vertex(half_edges.all), a_vertex(half_edges.bare), a_vertex(midpoints.all)});
  return {};
}

void TetraProse::add_places(const TetraData& data) {
  constexpr int kRuns = 7;
  for (const PlaceQuery& query :
       {two_isovalues(data), box_query(data, 1e-4 * data.range()), box_query(data, 0),
        plane_query(data, {}), plane_query(data, {kPaperBudget})}) {
    Answers answers;
    for (int i = 0; i < kRuns; ++i) ask(data.hierarchy, query, answers);
    places_.rows.push_back(
        {data.name, query.name, fmt::format("{:g}", 100 * query.first.inside / data.range()),
         fmt::format("{}", answers.n_cells), fmt::format("{:.1f}", data.share(answers.n_cells)),
         fmt::format("{:.2g}", 100 * answers.reached / data.range()),
         fmt::format("{}", answers.n_updates), milliseconds(median(answers.seconds)),
         fmt::format("{}", answers.n_moved), milliseconds(median(answers.moved_seconds))});
  }
}

Result<void> TetraProse::add(const TetraData& data) {
  add_places(data);
  return add_storage(data);
}

Result<void> TetraProse::publish(const std::string& directory) const {
  LODE_CHECK(bench::publish(storage_, directory));
  return bench::publish(places_, directory);
}

}  // namespace lode::bench
