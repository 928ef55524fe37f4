#include "bench/peers/vtk_grid.h"

#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>

namespace lode::bench {

void fill_grid(const TetraMesh& mesh, vtkUnstructuredGrid& grid) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(mesh.positions.size()));
  vtkNew<vtkDoubleArray> values;
  values->SetName(mesh.fields.front().name.c_str());
  values->SetNumberOfTuples(static_cast<vtkIdType>(mesh.positions.size()));
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    points->SetPoint(static_cast<vtkIdType>(v), mesh.positions[v].v.data());
    values->SetValue(static_cast<vtkIdType>(v), mesh.fields.front().values[v]);
  }
  vtkNew<vtkCellArray> cells;
  for (const auto& corners : mesh.tetrahedra) {
    std::array<vtkIdType, 4> ids{};
    std::copy(corners.begin(), corners.end(), ids.begin());
    cells->InsertNextCell(4, ids.data());
  }
  grid.SetPoints(points);
  grid.GetPointData()->SetScalars(values);
  grid.SetCells(VTK_TETRA, cells);
}

}  // namespace lode::bench
