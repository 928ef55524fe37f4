#include "lode/io/mesh_medit_solution.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "lode/io/mesh_checks.h"
#include "lode/io/mesh_medit_input.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

/// By place in the file, which component of the field it is; of a symmetric tensor, which has the
/// lower triangle, those off the diagonal are two.
constexpr std::array<std::uint8_t, 9> kAsTheyAre{0, 1, 2, 3, 4, 5, 6, 7, 8};
constexpr std::array<std::uint8_t, 9> kOfSymmetric{0, 1, 3, 1, 2, 4, 3, 4, 5};

struct SolutionKind {
  std::size_t n_stored = 0;
  int n_components = 0;
  std::span<const std::uint8_t> places;  ///< By component, which of those stored.
};

SolutionKind solution_kind(std::int64_t type) {
  switch (type) {
    case 1: return {1, 1, kAsTheyAre};
    case 2: return {3, 3, kAsTheyAre};
    case 3: return {6, 9, kOfSymmetric};
    default: return {9, 9, kAsTheyAre};
  }
}

Result<std::vector<SolutionKind>> read_kinds(MeditInput& input) {
  constexpr std::int64_t kMostFields = 4096;
  LODE_TRY(const std::int64_t n, input.small("a number of solutions", 1, kMostFields));
  std::vector<SolutionKind> kinds;
  for (std::int64_t i = 0; i < n; ++i) {
    LODE_TRY(const std::int64_t type,
             input.small("1 for a scalar, 2 for a vector, 3 or 4 for a tensor,", 1, 4));
    kinds.push_back(solution_kind(type));
  }
  return kinds;
}

Result<void> read_at_vertices(MeditInput& input, CellMesh& mesh) {
  LODE_TRY(const std::int64_t n,
           input.whole("a number of vertices", 0, static_cast<std::int64_t>(kMaxMeshCount)));
  if (std::cmp_not_equal(n, mesh.points.size()))
    return fail("{}: expected values at the {} vertices of {}, got {}", input.where(),
                mesh.points.size(), mesh.path, n);
  LODE_TRY(const std::vector<SolutionKind> kinds, read_kinds(input));
  std::size_t n_values = 0;
  for (const SolutionKind& kind : kinds) n_values += kind.n_stored;
  if (mesh.points.size() > input.n_left() / n_values)
    return fail("{}: expected {} values at {} vertices, got {} bytes", input.where(), n_values, n,
                input.n_left());
  std::vector<MeshField> fields;
  for (std::size_t f = 0; f < kinds.size(); ++f)
    fields.push_back({.name = kinds.size() == 1 ? "solution" : fmt::format("solution_{}", f + 1),
                      .type = ScalarType::float64,
                      .n_components = kinds[f].n_components,
                      .values = {}});
  std::array<double, 9> stored{};
  for (std::int64_t i = 0; i < n; ++i)
    for (std::size_t f = 0; f < kinds.size(); ++f) {
      for (std::size_t k = 0; k < kinds[f].n_stored; ++k) {
        LODE_TRY(stored[k], input.real("a value"));
      }
      for (int k = 0; k < kinds[f].n_components; ++k)
        fields[f].values.push_back(stored[kinds[f].places[static_cast<std::size_t>(k)]]);
    }
  for (MeshField& field : fields) mesh.point_fields.push_back(std::move(field));
  return {};
}

}  // namespace

std::string medit_solution_of(const std::string& mesh_path) {
  const bool is_binary = to_lower(mesh_path).ends_with("b");
  std::array<const char*, 2> extensions{".sol", ".solb"};
  if (is_binary) std::swap(extensions[0], extensions[1]);
  for (const char* const extension : extensions) {
    std::error_code status;
    const std::filesystem::path path =
        std::filesystem::path(mesh_path).replace_extension(extension);
    if (std::filesystem::is_regular_file(path, status)) return path.string();
  }
  return {};
}

Result<void> add_medit_solution(const std::string& path, const MeshReadOptions& options,
                                CellMesh& mesh) {
  LODE_TRY(MeditInput input, MeditInput::open(path, options));
  bool is_there = false;
  std::string before;
  while (true) {
    LODE_TRY(const std::string keyword, input.keyword(before));
    if (keyword.empty() || keyword == "end") break;
    before.clear();
    if (keyword == "dimension") LODE_CHECK(input.expect_three_dimensions("a solution"));
    if (keyword == "solatvertices" && is_there)
      return fail("{}: expected SolAtVertices once, got another", input.where());
    if (keyword == "solatvertices") {
      LODE_CHECK(read_at_vertices(input, mesh));
      is_there = true;
      before = "values";
    } else if (keyword.starts_with("solat")) {
      mesh.skipped_arrays.push_back(fmt::format("solution at {} ({})", keyword.substr(5),
                                                std::filesystem::path(path).filename().string()));
    }
  }
  if (is_there || options.solution.empty()) return {};
  return fail("{}: expected SolAtVertices, values at the {} vertices of {}, got none", path,
              mesh.points.size(), mesh.path);
}

}  // namespace lode::io
