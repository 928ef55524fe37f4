#include "bench/tetra_cases.h"

#include <filesystem>
#include <utility>

#include "bench/data_directory.h"
#include "lode/io/mesh_reader.h"
#include "lode/io/tetrahedra.h"

namespace lode::bench {
namespace {

constexpr std::uint64_t kNoiseSeed = 1;
constexpr int kNoiseSamples = 64;

}  // namespace

TetraCase noise_case(oracles::Cut cut) {
  return {.name = cut == oracles::Cut::in_five ? "noise_64" : "noise_64_in_six",
          .noise_samples = kNoiseSamples,
          .cut = cut};
}

std::vector<TetraCase> real_tetra_cases() {
  return {
      {.name = "blunt_fin", .file = "blunt_fin_187395tets.vtu", .field = "Density"},
      {.name = "oxygen_post", .file = "oxygen_post_513375tets.vtu", .field = "StagnationEnergy"}};
}

Result<TetraMesh> load(const TetraCase& tetra_case) {
  if (tetra_case.file.empty())
    return oracles::noise_mesh(tetra_case.noise_samples, tetra_case.cut, kNoiseSeed);
  const std::filesystem::path path = data_directory() / "tetra" / tetra_case.file;
  if (!std::filesystem::exists(path))
    return fail("skipped: no tetra/{} (set LODE_DATA)", tetra_case.file);
  LODE_TRY(CellMesh cells, io::read_cell_mesh(path.string(), {}));
  LODE_TRY(io::TetrahedraOutcome outcome,
           io::to_tetrahedra(std::move(cells), {.fields = {tetra_case.field}}));
  return std::move(outcome.mesh);
}

}  // namespace lode::bench
