#include "vtk_import.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>
#include <vector>

#include "parse.h"
#include "text.h"

namespace lode::cli {
namespace {

constexpr const char* kImporter = "lode-vtk-import";
constexpr std::array kImported{".e",    ".exo", ".ex2", ".g",    ".cgns", ".case", ".encas",
                               ".foam", ".xyz", ".p3d", ".pvtu", ".pvts", ".vtm"};

constexpr std::int64_t kMostFileSteps = 1'000'000'000;

std::string lower_extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

bool is_foam_case(const std::string& path) {
  std::error_code status;
  return std::filesystem::is_directory(path, status) &&
         std::filesystem::exists(std::filesystem::path(path) / "system" / "controlDict", status);
}

/// Whether a VTK XML file is compressed as VTK can unpack, but Lode cannot.
bool is_packed_for_vtk(const std::string& path) {
  constexpr std::size_t kMaxStart = 1024;
  std::string start(kMaxStart, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(file.gcount()));
  return start.find("vtkLZ4DataCompressor") != std::string::npos ||
         start.find("vtkLZMADataCompressor") != std::string::npos;
}

/// A directory of our own, which goes with what is in it.
class TemporaryFolder {
 public:
  static Result<TemporaryFolder> create() {
    std::error_code status;
    std::string name =
        (std::filesystem::temp_directory_path(status) / "lode-import-XXXXXX").string();
    if (status || ::mkdtemp(name.data()) == nullptr)
      return fail("{}: expected a directory for temporary files (TMPDIR), cannot make one", name);
    return TemporaryFolder(std::move(name));
  }
  TemporaryFolder(TemporaryFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;
  ~TemporaryFolder() {
    std::error_code status;
    if (!path_.empty()) std::filesystem::remove_all(path_, status);
  }

  [[nodiscard]] std::string file(const char* name) const { return path_ + "/" + name; }

 private:
  explicit TemporaryFolder(std::string path) : path_(std::move(path)) {}

  std::string path_;
};

/// Runs it. Its lines are notes; of a failure the last one is the message.
Result<void> run_importer(const std::string& path, const std::vector<std::string>& words,
                          Session& session) {
  LODE_TRY(ChildProgram child, ChildProgram::start(words, ChildErrors::read));
  std::vector<std::string> lines;
  while (true) {
    LODE_TRY(std::optional<std::string> line, child.read_line(session.progress()));
    if (!line) break;
    if (!line->empty()) lines.push_back(*std::move(line));
  }
  const int exit_code = child.wait();
  if (exit_code == 0) {
    for (const std::string& line : lines) session.note(fmt::format("{}: {}", path, line));
    return {};
  }
  if (exit_code == 1 && !lines.empty()) return fail("{}: {}", path, lines.back());
  return fail("{}: {} ended with exit code {}: {}", path, kImporter, exit_code,
              lines.empty() ? "it said nothing" : lines.back());
}

/// A number in each line, a blank, and a name, which may be empty.
std::vector<BoundaryPatch> read_patch_names(const std::string& path) {
  std::vector<BoundaryPatch> patches;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const std::size_t blank = line.find(' ');
    std::istringstream number(line.substr(0, blank));
    BoundaryPatch patch;
    if (!(number >> patch.id)) continue;
    if (blank != std::string::npos) patch.name = line.substr(blank + 1);
    patches.push_back(std::move(patch));
  }
  return patches;
}

bool is_gmsh_path(const std::string& path) { return lower_extension(path) == ".msh"; }

/// What Lode reads itself.
Result<CellMesh> read_own_cells(const std::string& path, const ReadingArguments& reading,
                                Session& session) {
  MeshReadOptions options{.solution = reading.solution};
  if (is_gmsh_path(path) && !reading.time.empty()) {
    LODE_TRY(const std::int64_t step, parse_integer("--time", reading.time, 0, kMostFileSteps));
    options.step = static_cast<std::size_t>(step);
  }
  LODE_TRY(CellMesh mesh, read_cell_mesh(path, options));
  if (!mesh.times.empty())
    session.note(fmt::format("{}: step {} of 0 to {} (time {})", path, mesh.step,
                             mesh.times.size() - 1, mesh.times[mesh.step]));
  return mesh;
}

}  // namespace

bool may_have_steps(const std::string& path) {
  return needs_vtk_import(path) || is_gmsh_path(path);
}

bool needs_vtk_import(const std::string& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".vtu" || extension == ".vts") return is_packed_for_vtk(path);
  return std::ranges::find(kImported, extension) != kImported.end() || is_foam_case(path);
}

bool is_cells_path(const std::string& path) {
  return is_cell_mesh_path(path) || needs_vtk_import(path);
}

bool holds_cells(const std::string& path) {
  return holds_tetrahedra(path) || needs_vtk_import(path);
}

Result<CellMesh> read_cells(const std::string& path, const ReadingArguments& reading,
                            Session& session) {
  if (!needs_vtk_import(path)) return read_own_cells(path, reading, session);
  const auto importer = find_program(kImporter);
  if (!importer)
    return fail(
        "{}: expected the program {}, which reads such files, beside lode or in PATH, found none; "
        "install libvtk9-dev and build again",
        path, kImporter);
  LODE_TRY(const TemporaryFolder folder, TemporaryFolder::create());
  const std::string grid = folder.file("grid.vtu");
  const std::string names = folder.file("patches.txt");
  // What starts with a dash would be an option.
  std::vector<std::string> words{*importer, std::filesystem::absolute(path).string(), grid,
                                 "--patches", names};
  if (!reading.time.empty()) words.insert(words.end(), {"--step", reading.time});
  LODE_CHECK(run_importer(path, words, session));
  auto cells = read_cell_mesh(grid, {});
  if (!cells) return fail("{}: as {} gives it: {}", path, kImporter, cells.error().message);
  cells->path = path;
  if (auto patches = read_patch_names(names); !patches.empty())
    cells->patch_names = std::move(patches);
  return cells;
}

}  // namespace lode::cli
