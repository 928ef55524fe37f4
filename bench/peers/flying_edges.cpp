#include "bench/peers/flying_edges.h"

#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkQuadricDecimation.h>
#include <vtkVersion.h>

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "bench/peers/vtk_threads.h"

namespace lode::bench {
namespace {

constexpr int kThreads = 2;

template <typename T>
constexpr int vtk_type() {
  if constexpr (std::is_same_v<T, std::uint8_t>)
    return VTK_UNSIGNED_CHAR;
  else if constexpr (std::is_same_v<T, std::int8_t>)
    return VTK_SIGNED_CHAR;
  else if constexpr (std::is_same_v<T, std::uint16_t>)
    return VTK_UNSIGNED_SHORT;
  else if constexpr (std::is_same_v<T, std::uint32_t>)
    return VTK_UNSIGNED_INT;
  else if constexpr (std::is_same_v<T, std::int32_t>)
    return VTK_INT;
  else if constexpr (std::is_same_v<T, std::uint64_t>)
    return VTK_UNSIGNED_LONG_LONG;
  else if constexpr (std::is_same_v<T, std::int64_t>)
    return VTK_LONG_LONG;
  else if constexpr (std::is_same_v<T, double>)
    return VTK_DOUBLE;
  // float, and int16: Debian's VTK 9.1 aborts on some int16 volumes.
  else
    return VTK_FLOAT;
}

void fill_image(const Volume& volume, vtkImageData& image) {
  const RegularGrid& grid = volume.info.grid;
  image.SetDimensions(grid.dims[0], grid.dims[1], grid.dims[2]);
  image.SetSpacing(grid.spacing.v.data());
  image.SetOrigin(grid.origin.v.data());
  image.SetDirectionMatrix(grid.direction.rows[0].v.data());
  visit_scalar_type(volume.info.type, [&]<typename T>() {
    image.AllocateScalars(vtk_type<T>(), 1);
    const auto samples = volume.as<T>();
    if constexpr (std::is_same_v<T, std::int16_t>)
      std::ranges::copy(samples, static_cast<float*>(image.GetScalarPointer()));
    else
      std::memcpy(image.GetScalarPointer(), samples.data(), samples.size_bytes());
  });
}

PeerCounts counts_of(vtkPolyData& surface) {
  return {static_cast<std::uint64_t>(surface.GetNumberOfPolys()),
          static_cast<std::uint64_t>(surface.GetNumberOfPoints())};
}

}  // namespace

class FlyingEdges::Pipeline {
 public:
  Pipeline(const Volume& volume, double isovalue, PeerNormals normals) {
    limit_vtk_threads(kThreads);
    fill_image(volume, *image_);
    filter_->SetInputData(image_);
    filter_->SetValue(0, isovalue);
    filter_->SetComputeNormals(normals == PeerNormals::on);
    filter_->ComputeGradientsOff();
    filter_->ComputeScalarsOff();
  }

  vtkPolyData* run() {
    filter_->Modified();
    filter_->Update();
    last_ = filter_->GetOutput();
    return last_;
  }
  vtkPolyData* decimate(double reduction) {
    decimation_->SetInputData(filter_->GetOutput());
    decimation_->SetTargetReduction(reduction);
    decimation_->Modified();
    decimation_->Update();
    last_ = decimation_->GetOutput();
    return last_;
  }
  /// Of the last of them that ran.
  [[nodiscard]] vtkPolyData* last() const { return last_; }

 private:
  vtkNew<vtkImageData> image_;
  vtkNew<vtkFlyingEdges3D> filter_;
  vtkNew<vtkQuadricDecimation> decimation_;
  vtkPolyData* last_ = nullptr;
};

std::string describe_peer() {
  limit_vtk_threads(kThreads);
  return fmt::format("VTK {}, {}, {} threads", vtkVersion::GetVTKVersion(), vtk_backend(),
                     n_vtk_threads());
}

FlyingEdges::FlyingEdges(const Volume& volume, double isovalue, PeerNormals normals)
    : pipeline_(std::make_unique<Pipeline>(volume, isovalue, normals)) {
  if (volume.info.type == ScalarType::int16)
    note_ = "peer reads float32: Debian's VTK 9.1 aborts on some int16 volumes";
}

FlyingEdges::FlyingEdges(FlyingEdges&&) noexcept = default;
FlyingEdges::~FlyingEdges() = default;

Result<PeerCounts> FlyingEdges::extract() {
  vtkPolyData* surface = pipeline_->run();
  if (surface == nullptr) return fail("vtkFlyingEdges3D: expected a surface, got no output");
  return counts_of(*surface);
}

Result<PeerCounts> FlyingEdges::extract_and_decimate(std::uint64_t target) {
  vtkPolyData* surface = pipeline_->run();
  if (surface == nullptr) return fail("vtkFlyingEdges3D: expected a surface, got no output");
  const auto full = static_cast<double>(surface->GetNumberOfPolys());
  if (full == 0) return PeerCounts{};
  return counts_of(
      *pipeline_->decimate(std::clamp(1.0 - static_cast<double>(target) / full, 0.0, 1.0)));
}

Surface FlyingEdges::surface() const {
  Surface surface;
  vtkPolyData* from = pipeline_->last();
  if (from == nullptr) return surface;
  for (vtkIdType v = 0; v < from->GetNumberOfPoints(); ++v) {
    const double* p = from->GetPoint(v);
    surface.positions.push_back(
        {{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}});
  }
  vtkIdType n = 0;
  const vtkIdType* ids = nullptr;
  vtkCellArray* cells = from->GetPolys();
  for (cells->InitTraversal(); cells->GetNextCell(n, ids) != 0;)
    surface.triangles.push_back({static_cast<std::uint32_t>(ids[0]),
                                 static_cast<std::uint32_t>(ids[1]),
                                 static_cast<std::uint32_t>(ids[2])});
  return surface;
}

}  // namespace lode::bench
