#include "bench/peers/linear_contour.h"

#include <vtkAlgorithm.h>
#include <vtkContour3DLinearGrid.h>
#include <vtkDataObject.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>

#include "bench/peers/vtk_grid.h"
#include "bench/peers/vtk_threads.h"

namespace lode::bench {

class LinearContour::Pipeline {
 public:
  explicit Pipeline(const TetraMesh& mesh) {
    limit_vtk_threads(2);
    fill_grid(mesh, *grid_);
    filter_->SetInputData(grid_);
    filter_->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS,
                                    mesh.fields.front().name.c_str());
    filter_->SetOutputPointsPrecision(vtkAlgorithm::SINGLE_PRECISION);
  }

  vtkPolyData* run(double isovalue, PeerVertices vertices, PeerNormals normals) {
    filter_->SetValue(0, isovalue);
    filter_->SetMergePoints(static_cast<vtkTypeBool>(vertices == PeerVertices::shared));
    filter_->SetComputeNormals(static_cast<vtkTypeBool>(normals == PeerNormals::on));
    filter_->Modified();
    filter_->Update();
    return vtkPolyData::SafeDownCast(filter_->GetOutputDataObject(0));
  }

 private:
  vtkNew<vtkUnstructuredGrid> grid_;
  vtkNew<vtkContour3DLinearGrid> filter_;
};

LinearContour::LinearContour(const TetraMesh& mesh) : pipeline_(std::make_unique<Pipeline>(mesh)) {}
LinearContour::LinearContour(LinearContour&&) noexcept = default;
LinearContour::~LinearContour() = default;

Result<PeerCounts> LinearContour::extract(double isovalue, PeerVertices vertices,
                                          PeerNormals normals) {
  vtkPolyData* surface = pipeline_->run(isovalue, vertices, normals);
  if (surface == nullptr || surface->GetNumberOfPolys() == 0)
    return fail("vtkContour3DLinearGrid: expected a surface, got none");
  return PeerCounts{static_cast<std::uint64_t>(surface->GetNumberOfPolys()),
                    static_cast<std::uint64_t>(surface->GetNumberOfPoints())};
}

}  // namespace lode::bench
