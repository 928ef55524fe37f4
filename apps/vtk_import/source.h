#pragma once

#include <vtkDataObject.h>
#include <vtkSmartPointer.h>

#include <optional>
#include <string>

#include "flatten.h"

namespace lode::vtk_import {

/// What VTK's reader makes of a file.
struct Source {
  vtkSmartPointer<vtkDataObject> data;
  BlockPoints points = BlockPoints::own;
  std::string format;  ///< "Exodus II"
  int step = 0;
  int n_steps = 1;
  bool has_time = false;
  double time = 0;  ///< Of the step; 0 where the file has none.
};

/// Reads one step, from 0, of an Exodus II (.e .exo .ex2 .g), CGNS (.cgns), EnSight (.case .encas),
/// OpenFOAM (.foam, or a case's directory), PLOT3D (.xyz .p3d, with the .q of the same name where
/// it is there) or VTK XML file (.vtu .vts .pvtu .pvts .vtm), with all fields; none: the last.
/// Throws std::runtime_error on other files, and on steps that are not there.
[[nodiscard]] Source read_source(const std::string& path, std::optional<int> step);

}  // namespace lode::vtk_import
