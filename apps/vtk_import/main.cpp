// lode-vtk-import: reads what VTK can and Lode cannot, and writes what Lode reads: one grid, .vtu.
// A program of its own, so that lode needs no VTK; lode runs it where it is there.
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>

#include "source.h"

namespace lode::vtk_import {
namespace {

constexpr int kFailure = 1;
constexpr int kUsage = 2;

constexpr const char* kHelp =
    "Usage: lode-vtk-import IN OUT.vtu [--step N] [--patches NAMES.txt]\n\n"
    "Reads Exodus II (.e .exo .ex2 .g), CGNS (.cgns), EnSight (.case .encas), OpenFOAM (.foam, or\n"
    "a case's directory), PLOT3D (.xyz .p3d, and the .q of the same name) or VTK XML (.vtu .vts\n"
    ".pvtu .pvts .vtm, also compressed by LZ4 or LZMA) with VTK, and writes its solid cells as "
    "one\n"
    "grid that lode reads, and faces of its boundary that are in blocks or side sets, with "
    "PatchId.\n"
    "lode itself runs it for such files.\n\n"
    "  --step N             Time step, from 0 (default: the last)\n"
    "  --patches NAMES.txt  Write PatchId and name of each of these, a line each\n"
    "  --help               This text\n";

/// Keeps the first error that VTK reports, which would otherwise only be shown.
class ErrorCatcher final : public vtkOutputWindow {
 public:
  static ErrorCatcher* New();
  vtkTypeMacro(ErrorCatcher, vtkOutputWindow);

  void DisplayErrorText(const char* text) override {
    if (first_.empty()) first_ = in_one_line(text);
  }
  void DisplayText(const char* text) override { std::cerr << in_one_line(text) << '\n'; }
  [[nodiscard]] const std::string& first() const { return first_; }

 private:
  /// Without where in VTK's sources it comes from.
  static std::string in_one_line(std::string text) {
    const std::size_t begin = text.find("): ");
    if (begin != std::string::npos) text.erase(0, begin + 3);
    for (char& c : text)
      if (c == '\n' || c == '\r') c = ' ';
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return text;
  }

  std::string first_;
};
vtkStandardNewMacro(ErrorCatcher);

struct Arguments {
  std::string input;
  std::string output;
  std::optional<int> step;
  std::string names;  ///< Empty: not written.
};

std::optional<Arguments> parse_arguments(int argc, char** argv) {
  Arguments arguments;
  int n_paths = 0;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--step" && i + 1 < argc) {
      char* end = nullptr;
      const long step = std::strtol(argv[++i], &end, 10);
      if (*end != '\0' || end == argv[i] || step < 0 || step > 1000000000) return {};
      arguments.step = static_cast<int>(step);
    } else if (word == "--patches" && i + 1 < argc) {
      arguments.names = argv[++i];
    } else if (word.starts_with("--") || n_paths == 2) {
      return {};
    } else {
      (n_paths++ == 0 ? arguments.input : arguments.output) = word;
    }
  }
  if (n_paths != 2 || std::filesystem::path(arguments.output).extension() != ".vtu") return {};
  return arguments;
}

void say_what_came(const Source& source, const Flattened& made) {
  std::cerr << source.format;
  if (source.n_steps > 1)
    std::cerr << ", step " << source.step << " of 0 to " << source.n_steps - 1 << " (time "
              << source.time << ")";
  if (made.blocks.empty())
    std::cerr << ": one grid";
  else
    std::cerr << ": " << made.blocks.size() << (made.blocks.size() == 1 ? " block" : " blocks");
  if (!made.patches.empty())
    std::cerr << ", " << made.patches.size() << (made.patches.size() == 1 ? " patch" : " patches");
  if (made.n_left_out > 0)
    std::cerr << ", " << made.n_left_out << " without solid cells or faces on these left out";
  if (made.n_faces_left_out > 0)
    std::cerr << ", " << made.n_faces_left_out << " faces on no solid cell left out";
  std::cerr << '\n';
  constexpr std::size_t kMaxShown = 20;
  const std::size_t n_shown = std::min(made.blocks.size(), kMaxShown);
  for (std::size_t i = 0; i < n_shown; ++i) {
    const Block& block = made.blocks[i];
    const std::string name = block.name.empty() ? "block " + std::to_string(i + 1) : block.name;
    std::cerr << "region " << block.region << ": " << name << ", " << block.n_cells << " cells\n";
  }
  if (n_shown < made.blocks.size())
    std::cerr << "and " << made.blocks.size() - n_shown << " more\n";
}

/// Whole or not at all: what is there when something fails has another name, and goes.
void write_grid(vtkUnstructuredGrid& grid, const std::string& path) {
  const std::string part = path + ".part";
  const auto writer = vtkSmartPointer<vtkXMLUnstructuredGridWriter>::New();
  writer->SetInputData(&grid);
  writer->SetFileName(part.c_str());
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToNone();
  writer->SetHeaderTypeToUInt64();
  const bool is_written = writer->Write() != 0;
  std::error_code status;
  if (is_written) std::filesystem::rename(part, path, status);
  if (is_written && !status) return;
  std::filesystem::remove(part, status);
  throw std::runtime_error("cannot write " + path);
}

void write_names(const std::vector<NamedPatch>& patches, const std::string& path) {
  std::ofstream file(path);
  for (const NamedPatch& patch : patches) {
    std::string name = patch.name;
    std::replace(name.begin(), name.end(), '\n', ' ');
    file << patch.id << ' ' << name << '\n';
  }
  file.close();
  if (!file) throw std::runtime_error("cannot write " + path);
}

/// As VTK's own writers have it.
void add_time(double time, vtkUnstructuredGrid& grid) {
  const auto value = vtkSmartPointer<vtkDoubleArray>::New();
  value->SetName("TimeValue");
  value->InsertNextValue(time);
  grid.GetFieldData()->AddArray(value);
}

int run(const Arguments& arguments) {
  const auto errors = vtkSmartPointer<ErrorCatcher>::New();
  vtkOutputWindow::SetInstance(errors);
  try {
    const Source source = read_source(arguments.input, arguments.step);
    if (!errors->first().empty()) throw std::runtime_error(errors->first());
    const Flattened made = flatten(*source.data, source.points);
    say_what_came(source, made);
    if (source.has_time) add_time(source.time, *made.grid);
    if (!arguments.names.empty()) write_names(made.patches, arguments.names);
    write_grid(*made.grid, arguments.output);
    if (!errors->first().empty()) throw std::runtime_error(errors->first());
    return 0;
  } catch (const std::exception& error) {
    std::cerr << (errors->first().empty() ? error.what() : errors->first()) << '\n';
    return kFailure;
  }
}

}  // namespace
}  // namespace lode::vtk_import

int main(int argc, char** argv) {
  using namespace lode::vtk_import;
  if (argc == 2 && std::string(argv[1]) == "--help") {
    std::cout << kHelp;
    return 0;
  }
  const auto arguments = parse_arguments(argc, argv);
  if (arguments) return run(*arguments);
  std::cerr << kHelp;
  return kUsage;
}
