#include "vtk_import.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
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

/// Beside this program, else the first in PATH; none where it is nowhere.
std::optional<std::string> find_importer() {
  std::error_code status;
  const auto own = std::filesystem::read_symlink("/proc/self/exe", status);
  std::vector<std::filesystem::path> folders;
  if (!status) folders.push_back(own.parent_path());
  const char* const path = std::getenv("PATH");
  std::istringstream list(path == nullptr ? "" : path);
  for (std::string folder; std::getline(list, folder, ':');)
    if (!folder.empty()) folders.emplace_back(folder);
  for (const std::filesystem::path& folder : folders) {
    const std::string program = (folder / kImporter).string();
    if (std::filesystem::is_regular_file(program, status) && ::access(program.c_str(), X_OK) == 0)
      return program;
  }
  return {};
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

/// A program that runs, and what it writes to stderr; what is left of it is ended with this.
class Child {
 public:
  static Result<Child> start(const std::vector<std::string>& words) {
    std::array<int, 2> ends{-1, -1};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0)
      return fail("{}: cannot be started: {}", words[0], std::strerror(errno));
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
    std::vector<char*> argv;
    argv.reserve(words.size() + 1);
    for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    pid_t process = -1;
    const int status =
        ::posix_spawn(&process, words[0].c_str(), &actions, nullptr, argv.data(), environ);
    ::posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    if (status == 0) return Child(process, ends[0]);
    ::close(ends[0]);
    return fail("{}: cannot be started: {}", words[0], std::strerror(status));
  }
  Child(Child&& other) noexcept
      : process_(std::exchange(other.process_, -1)), errors_(std::exchange(other.errors_, -1)) {}
  Child& operator=(Child&&) = delete;
  ~Child() {
    if (process_ > 0) {
      ::kill(process_, SIGKILL);
      wait();
    }
    if (errors_ >= 0) ::close(errors_);
  }

  /// All that it says; an error once cancelled.
  [[nodiscard]] Result<std::string> read_all(const Progress& progress) const {
    constexpr int kPatienceMs = 100;
    std::string text;
    std::array<char, 4096> part{};
    while (true) {
      if (progress.is_cancelled()) return cancelled_error();
      pollfd stream{errors_, POLLIN, 0};
      if (::poll(&stream, 1, kPatienceMs) <= 0) continue;
      const ssize_t n = ::read(errors_, part.data(), part.size());
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return text;
      text.append(part.data(), static_cast<std::size_t>(n));
    }
  }
  /// Its exit status, as a shell says it.
  int wait() {
    int status = 0;
    while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  Child(pid_t process, int errors) : process_(process), errors_(errors) {}

  pid_t process_ = -1;
  int errors_ = -1;
};

/// Runs it. Its lines are notes; of a failure the last one is the message.
Result<void> run_importer(const std::string& path, const std::vector<std::string>& words,
                          Session& session) {
  LODE_TRY(Child child, Child::start(words));
  LODE_TRY(const std::string said, child.read_all(session.progress()));
  const int exit_code = child.wait();
  std::vector<std::string> lines;
  std::istringstream stream(said);
  for (std::string line; std::getline(stream, line);)
    if (!line.empty()) lines.push_back(line);
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
  const auto importer = find_importer();
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
