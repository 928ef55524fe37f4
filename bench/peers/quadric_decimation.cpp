#include "bench/peers/quadric_decimation.h"

#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridQuadricDecimation.h>

#include <algorithm>
#include <array>
#include <string>

#include "bench/peers/vtk_grid.h"

namespace lode::bench {

class QuadricDecimation::Pipeline {
 public:
  explicit Pipeline(const TetraMesh& mesh) {
    fill_grid(mesh, *grid_);
    filter_->SetInputData(grid_);
    filter_->SetScalarsName(mesh.fields.front().name.c_str());
  }

  vtkUnstructuredGrid* run(std::uint64_t n_cells) {
    filter_->SetNumberOfTetsOutput(static_cast<int>(n_cells));
    filter_->Modified();
    filter_->Update();
    return filter_->GetOutput();
  }
  [[nodiscard]] vtkUnstructuredGrid* output() const { return filter_->GetOutput(); }

 private:
  vtkNew<vtkUnstructuredGrid> grid_;
  vtkNew<vtkUnstructuredGridQuadricDecimation> filter_;
};

QuadricDecimation::QuadricDecimation(const TetraMesh& mesh)
    : pipeline_(std::make_unique<Pipeline>(mesh)) {}

QuadricDecimation::QuadricDecimation(QuadricDecimation&&) noexcept = default;
QuadricDecimation::~QuadricDecimation() = default;

Result<std::uint64_t> QuadricDecimation::decimate(std::uint64_t n_cells) {
  vtkUnstructuredGrid* left = pipeline_->run(n_cells);
  if (left == nullptr || left->GetNumberOfCells() == 0)
    return fail("vtkUnstructuredGridQuadricDecimation: expected about {} cells, got none", n_cells);
  return static_cast<std::uint64_t>(left->GetNumberOfCells());
}

TetraMesh QuadricDecimation::mesh() const {
  TetraMesh mesh;
  vtkUnstructuredGrid* from = pipeline_->output();
  vtkDataArray* values = from->GetPointData()->GetArray(0);
  MeshField field{
      .name = values->GetName(), .type = ScalarType::float64, .n_components = 1, .values = {}};
  for (vtkIdType v = 0; v < from->GetNumberOfPoints(); ++v) {
    const double* p = from->GetPoint(v);
    mesh.positions.push_back({{p[0], p[1], p[2]}});
    field.values.push_back(values->GetTuple1(v));
  }
  mesh.fields.push_back(std::move(field));
  vtkIdType n = 0;
  const vtkIdType* ids = nullptr;
  vtkCellArray* cells = from->GetCells();
  for (cells->InitTraversal(); cells->GetNextCell(n, ids) != 0;) {
    auto& corners = mesh.tetrahedra.emplace_back();
    std::transform(ids, ids + 4, corners.begin(),
                   [](vtkIdType id) { return static_cast<std::uint32_t>(id); });
  }
  return mesh;
}

}  // namespace lode::bench
