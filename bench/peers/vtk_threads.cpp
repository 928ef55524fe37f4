#include "bench/peers/vtk_threads.h"

#include <vtkSMPTools.h>

namespace lode::bench {

void limit_vtk_threads(int n) { vtkSMPTools::Initialize(n); }

std::string vtk_backend() { return vtkSMPTools::GetBackend(); }

int n_vtk_threads() { return vtkSMPTools::GetEstimatedNumberOfThreads(); }

}  // namespace lode::bench
