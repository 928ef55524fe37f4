#include "source.h"

#include <vtkAlgorithm.h>
#include <vtkCGNSReader.h>
#include <vtkExodusIIReader.h>
#include <vtkGenericEnSightReader.h>
#include <vtkInformation.h>
#include <vtkMultiBlockPLOT3DReader.h>
#include <vtkOpenFOAMReader.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkXMLMultiBlockDataReader.h>
#include <vtkXMLPStructuredGridReader.h>
#include <vtkXMLPUnstructuredGridReader.h>
#include <vtkXMLStructuredGridReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "exodus_elements.h"

namespace lode::vtk_import {
namespace {

using Reader = vtkSmartPointer<vtkAlgorithm>;

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

// Arrays are known, and can be chosen, once the reader has looked at the file.

Reader exodus_reader(const std::string& path) {
  check_exodus_elements(path);
  auto reader = vtkSmartPointer<vtkExodusIIReader>::New();
  reader->SetFileName(path.c_str());
  // Blocks keep the file's points: what lies between two of them conforms.
  reader->SetSqueezePoints(false);
  reader->SetApplyDisplacements(0);
  reader->GenerateObjectIdCellArrayOn();
  reader->UpdateInformation();
  reader->SetAllArrayStatus(vtkExodusIIReader::NODAL, 1);
  reader->SetAllArrayStatus(vtkExodusIIReader::ELEM_BLOCK, 1);
  for (int i = 0; i < reader->GetNumberOfSideSetArrays(); ++i)
    reader->SetSideSetArrayStatus(reader->GetSideSetArrayName(i), 1);
  return reader;
}

Reader cgns_reader(const std::string& path) {
  auto reader = vtkSmartPointer<vtkCGNSReader>::New();
  reader->SetFileName(path.c_str());
  reader->UpdateInformation();
  reader->EnableAllBases();
  reader->LoadBndPatchOn();
  reader->EnableAllPointArrays();
  reader->EnableAllCellArrays();
  return reader;
}

Reader ensight_reader(const std::string& path) {
  auto reader = vtkSmartPointer<vtkGenericEnSightReader>::New();
  const std::filesystem::path whole(path);
  reader->SetFilePath(whole.has_parent_path() ? whole.parent_path().c_str() : ".");
  reader->SetCaseFileName(whole.filename().c_str());
  reader->ReadAllVariablesOn();
  reader->UpdateInformation();
  return reader;
}

Reader foam_reader(const std::string& path) {
  auto reader = vtkSmartPointer<vtkOpenFOAMReader>::New();
  const bool is_directory = std::filesystem::is_directory(path);
  reader->SetFileName(is_directory
                          ? (std::filesystem::path(path) / "system" / "controlDict").c_str()
                          : path.c_str());
  // Polyhedra and values of cells are Lode's to split and to average.
  reader->SetDecomposePolyhedra(0);
  reader->SetCreateCellToPoint(0);
  reader->SetSkipZeroTime(false);
  reader->UpdateInformation();
  reader->EnableAllCellArrays();
  reader->EnableAllPointArrays();
  reader->EnableAllPatchArrays();
  return reader;
}

Reader plot3d_reader(const std::string& path) {
  auto reader = vtkSmartPointer<vtkMultiBlockPLOT3DReader>::New();
  reader->SetXYZFileName(path.c_str());
  std::filesystem::path solution = std::filesystem::path(path).replace_extension(".q");
  if (!std::filesystem::exists(solution)) solution.replace_extension(".Q");
  if (!std::filesystem::exists(solution))
    throw std::runtime_error("expected the solution " + solution.stem().string() +
                             ".q beside the grid, got none");
  reader->SetQFileName(solution.c_str());
  reader->AutoDetectFormatOn();
  reader->UpdateInformation();
  return reader;
}

template <typename T>
Reader xml_reader(const std::string& path) {
  auto reader = vtkSmartPointer<T>::New();
  reader->SetFileName(path.c_str());
  reader->UpdateInformation();
  return reader;
}

struct Format {
  const char* extension;
  const char* name;
  Reader (*open)(const std::string& path);
  BlockPoints points = BlockPoints::own;
};

constexpr std::array<Format, 16> kFormats{{
    {".e", "Exodus II", exodus_reader, BlockPoints::shared},
    {".exo", "Exodus II", exodus_reader, BlockPoints::shared},
    {".ex2", "Exodus II", exodus_reader, BlockPoints::shared},
    {".g", "Exodus II", exodus_reader, BlockPoints::shared},
    {".cgns", "CGNS", cgns_reader},
    {".case", "EnSight", ensight_reader},
    {".encas", "EnSight", ensight_reader},
    {".foam", "OpenFOAM", foam_reader},
    {".xyz", "PLOT3D", plot3d_reader},
    {".p3d", "PLOT3D", plot3d_reader},
    {".vtu", "VTK XML", xml_reader<vtkXMLUnstructuredGridReader>},  // what Lode cannot unpack
    {".vts", "VTK XML", xml_reader<vtkXMLStructuredGridReader>},
    {".pvtu", "VTK XML", xml_reader<vtkXMLPUnstructuredGridReader>},
    {".pvts", "VTK XML", xml_reader<vtkXMLPStructuredGridReader>},
    {".vtm", "VTK XML", xml_reader<vtkXMLMultiBlockDataReader>},
    {"", "OpenFOAM", foam_reader},  // a directory
}};

const Format& format_of(const std::string& path) {
  const std::string extension =
      std::filesystem::is_directory(path) ? "" : lower_extension(std::filesystem::path(path));
  const auto* const found =
      std::find_if(kFormats.begin(), kFormats.end(),
                   [&](const Format& format) { return format.extension == extension; });
  if (found == kFormats.end() || (extension.empty() && !std::filesystem::is_directory(path)))
    throw std::runtime_error(
        "expected .e .exo .ex2 .g .cgns .case .encas .foam .xyz .p3d .vtu .vts .pvtu .pvts .vtm or "
        "an OpenFOAM case, got '" +
        extension + "'");
  return *found;
}

/// VTK's readers say little of files that cannot be opened, or crash.
void check_readable(const std::string& path) {
  std::error_code status;
  if (!std::filesystem::exists(path, status))
    throw std::runtime_error("expected a file, found none");
  if (std::filesystem::is_directory(path, status)) {
    if (std::filesystem::exists(std::filesystem::path(path) / "system" / "controlDict", status))
      return;
    throw std::runtime_error("expected a file, or an OpenFOAM case with system/controlDict");
  }
  if (!std::ifstream(path).good()) throw std::runtime_error("cannot be opened");
}

void choose_step(vtkAlgorithm& reader, std::optional<int> step, Source& source) {
  vtkInformation* const about = reader.GetOutputInformation(0);
  auto* const key = vtkStreamingDemandDrivenPipeline::TIME_STEPS();
  const int n = about->Has(key) ? about->Length(key) : 0;
  source.n_steps = std::max(n, 1);
  source.step = step.value_or(source.n_steps - 1);
  if (source.step < 0 || source.step >= source.n_steps)
    throw std::runtime_error("expected a step from 0 to " + std::to_string(source.n_steps - 1) +
                             ", got " + std::to_string(source.step));
  if (n == 0) {
    reader.Update();
    return;
  }
  source.has_time = true;
  source.time = about->Get(key)[source.step];
  reader.UpdateTimeStep(source.time);
}

}  // namespace

Source read_source(const std::string& path, std::optional<int> step) {
  check_readable(path);
  const Format& format = format_of(path);
  const Reader reader = format.open(path);
  Source source{.data = nullptr, .points = format.points, .format = format.name};
  choose_step(*reader, step, source);
  source.data = reader->GetOutputDataObject(0);
  if (source.data == nullptr) throw std::runtime_error("VTK's reader gave nothing");
  return source;
}

}  // namespace lode::vtk_import
