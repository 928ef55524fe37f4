// The results of Cignoni, De Floriani, Magillo, Puppo, Scopigno, "Selective Refinement Queries for
// Volume Visualization of Unstructured Tetrahedral Meshes" (2004), section 8, tables 1 to 3 and its
// text, beside ours: docs/models/tetra_mt.md. Theirs were measured on a Pentium III of 800 MHz, and
// of what they measured only what their text says is known here.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/papers/table.h"
#include "bench/papers/tetra_data.h"
#include "bench/papers/tetra_prose.h"
#include "bench/tetra_cases.h"
#include "bench/timing.h"
#include "lode/api/tetra_dataset.h"
#include "lode/mappers/mesh_boundary.h"
#include "lode/mappers/mesh_isosurface.h"
#include "lode/models/tetra_mt/tetra_cut.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"
#include "tests/oracles/tetra_surfaces.h"

namespace lode::bench {
namespace {

using tetra_mt::TetraCut;

constexpr int kIsovalues = 9;  ///< Evenly between the field's ends.
constexpr std::array<double, 6> kUniform{10, 5, 2, 1, 0.1, 0};  ///< Percent of the range.
constexpr std::array<double, 3> kByIsovalue{5, 1, 0};

struct Settings {
  std::string only;
  std::string directory;
};

double isovalue_of(const TetraData& data, int k) {
  return data.low + k * data.range() / (kIsovalues + 1);
}

/// Of the data's mesh or a cut: vertices keep as far from others in both.
Surface isosurface(const TetraData& data, const SimplexMesh& mesh, double isovalue,
                   Threads threads) {
  Surface surface;
  add_isosurface(mesh, isovalue, {.margin = data.margin, .threads = threads}, surface);
  return surface;
}

double isosurface_seconds(const TetraData& data, const SimplexMesh& mesh, double isovalue) {
  return median_seconds([&] {
    const auto start = Clock::now();
    const Surface surface = isosurface(data, mesh, isovalue, {1});
    return surface.triangles.empty() ? 0 : seconds_since(start);
  });
}

/// From the base, on one thread.
struct Refined {
  Standing standing;
  double seconds = 0;
};
Refined refine(const TetraData& data, const Demand& demand) {
  Refined refined;
  refined.seconds = median_seconds([&] {
    TetraCut cut(data.hierarchy);
    Engine<TetraCut> engine(cut);
    const auto start = Clock::now();
    engine.set_query(demand, {}, FocusChange::changed, ApplyOrder::nearest_first);
    engine.finish();
    const double seconds = seconds_since(start);
    refined.standing = engine.standing();
    return seconds;
  });
  return refined;
}

class Tables {
 public:
  void add_parameters(const TetraData& data);
  void add_uniform(const TetraData& data);
  Result<void> add_isovalues(const TetraData& data);
  [[nodiscard]] Result<void> publish(const std::string& directory) const;

 private:
  Table parameters_{"tetra_parameters",
                    "Table 1: the meshes, and what building a hierarchy takes on two threads",
                    {{"data", "data set"},
                     {"vertices", "vertices"},
                     {"tetrahedra", "tetrahedra"},
                     {"boundary", "boundary triangles"},
                     {"range", "field range"},
                     {"triangles", "mean isosurface, triangles"},
                     {"build_s", "build, s"}},
                    {}};
  Table uniform_{"tetra_uniform",
                 "Table 2: meshes at a uniform level of detail, from the base, one thread",
                 {{"data", "data set"},
                  {"error", "error, % of the range"},
                  {"vertices", "vertices"},
                  {"tetrahedra", "tetrahedra"},
                  {"share", "% of them"},
                  {"ms", "time, ms"},
                  {"rate", "updates a second"}},
                 {}};
  Table isovalues_{
      "tetra_isovalues",
      "Table 3: isosurfaces from meshes whose level of detail is variable, by isovalue; "
      "from the base, one thread",
      {{"data", "data set"},
       {"isovalue", "isovalue, % of the range"},
       {"error", "error, % of the range"},
       {"tetrahedra", "tetrahedra"},
       {"share", "% of them"},
       {"triangles", "triangles"},
       {"refine_ms", "refinement, ms"},
       {"surface_ms", "isosurface, ms"},
       {"full_triangles", "reference: triangles"},
       {"full_ms", "isosurface, ms"}},
      {}};
};

void Tables::add_parameters(const TetraData& data) {
  std::size_t n_triangles = 0;
  for (int k = 1; k <= kIsovalues; ++k)
    n_triangles +=
        isosurface(data, data.cells, isovalue_of(data, k), kTableThreads).triangles.size();
  const Surface boundary = mesh_boundary(data.cells, {}, kTableThreads);
  parameters_.rows.push_back(
      {data.name, fmt::format("{}", data.mesh.positions.size()),
       fmt::format("{}", data.mesh.tetrahedra.size()), fmt::format("{}", boundary.triangles.size()),
       fmt::format("{:.4g} to {:.4g}", data.low, data.high),
       fmt::format("{}", n_triangles / kIsovalues), fmt::format("{:.2f}", data.build_s)});
}

void Tables::add_uniform(const TetraData& data) {
  for (const double percent : kUniform) {
    const Refined refined = refine(data, uniform_demand(percent / 100 * data.range()));
    const Standing& standing = refined.standing;
    const std::uint64_t n_base = data.hierarchy.head().shape.n_base_vertices;
    uniform_.rows.push_back(
        {data.name, fmt::format("{:g}", percent), fmt::format("{}", n_base + standing.n_applied),
         fmt::format("{}", standing.n_cells), fmt::format("{:.1f}", data.share(standing.n_cells)),
         milliseconds(refined.seconds),
         fmt::format("{:.0f}", static_cast<double>(standing.n_applied) / refined.seconds)});
  }
}

Result<void> Tables::add_isovalues(const TetraData& data) {
  for (int k = 1; k <= kIsovalues; ++k) {
    const double isovalue = isovalue_of(data, k);
    const Surface full = isosurface(data, data.cells, isovalue, kTableThreads);
    const double full_s = isosurface_seconds(data, data.cells, isovalue);
    for (const double percent : kByIsovalue) {
      const double tolerance = percent / 100 * data.range();
      const Refined refined = refine(data, isovalue_demand(isovalue, tolerance));
      TetraMeshOptions options;
      options.query.isovalues = {isovalue};
      options.query.max_error = tolerance;
      options.threads = kTableThreads;
      SimplexMesh cut;
      Progress progress;
      LODE_TRY(const MeshReport report, data.dataset.extract_mesh(options, cut, progress));
      const Surface surface = isosurface(data, cut, isovalue, kTableThreads);
      if (percent == 0 && oracles::sorted_triangles(surface) != oracles::sorted_triangles(full))
        return fail(
            "{}: expected the isosurface of {} to be the mesh's {} triangles at a tolerance of 0, "
            "got {}",
            data.name, isovalue, full.triangles.size(), surface.triangles.size());
      isovalues_.rows.push_back(
          {data.name, fmt::format("{}", 100 * k / (kIsovalues + 1)), fmt::format("{:g}", percent),
           fmt::format("{}", report.n_cells), fmt::format("{:.1f}", data.share(report.n_cells)),
           fmt::format("{}", surface.triangles.size()), milliseconds(refined.seconds),
           milliseconds(isosurface_seconds(data, cut, isovalue)),
           fmt::format("{}", full.triangles.size()), milliseconds(full_s)});
    }
  }
  return {};
}

Result<void> Tables::publish(const std::string& directory) const {
  for (const Table* table : {&parameters_, &uniform_, &isovalues_})
    LODE_CHECK(bench::publish(*table, directory));
  return {};
}

Result<void> run(const Settings& settings) {
  std::error_code failure;
  if (!settings.directory.empty()) std::filesystem::create_directories(settings.directory, failure);
  if (failure) return fail("{}: {}", settings.directory, failure.message());
  std::vector<TetraCase> cases = real_tetra_cases();
  cases.push_back(noise_case(oracles::Cut::in_six));
  Tables tables;
  TetraProse prose;
  for (const TetraCase& tetra_case : cases) {
    if (tetra_case.name.find(settings.only) == std::string::npos) continue;
    const auto data = prepare(tetra_case);
    if (!data) {
      fmt::print("{}: {}\n\n", tetra_case.name, data.error().message);
      continue;
    }
    tables.add_parameters(*data);
    tables.add_uniform(*data);
    LODE_CHECK(tables.add_isovalues(*data));
    LODE_CHECK(prose.add(*data));
  }
  fmt::print("Times are medians of seven.\n\n");
  LODE_CHECK(tables.publish(settings.directory));
  return prose.publish(settings.directory);
}

}  // namespace
}  // namespace lode::bench

int main(int argc, char** argv) {
  CLI::App app("The paper's results on meshes of tetrahedra beside ours");
  lode::bench::Settings settings;
  app.add_option("--only", settings.only, "Only data sets whose name contains this");
  app.add_option("--out", settings.directory, "Directory for the tables as Markdown and CSV");
  CLI11_PARSE(app, argc, argv);
  if (const auto done = lode::bench::run(settings); !done) {
    fmt::print(stderr, "{}\n", done.error().message);
    return 1;
  }
  return 0;
}
