#pragma once

#include <cstdint>
#include <memory>

#include "lode/api/tetra_dataset.h"
#include "lode/api/tetra_extraction.h"
#include "lode/core/mesh.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"

namespace lode {

/// Questions to a mesh one after another: each answer is refined from the cut of the last one, with
/// as many splits and collapses as they differ in (Cignoni, De Floriani, Magillo, Puppo, Scopigno
/// 2004, section 4.3). Answers are those of TetraDataset's members of the same names, bit for bit,
/// but where a deadline ends them: then they are as far as refining the last one came. Of another
/// field, and of the first question with tolerances in space, they begin at the base again.
/// By one thread at a time; the dataset must outlive it.
class TetraSession {
 public:
  explicit TetraSession(const TetraDataset& dataset);
  TetraSession(TetraSession&&) noexcept;
  TetraSession& operator=(TetraSession&&) noexcept;
  ~TetraSession();

  [[nodiscard]] Result<MeshReport> extract_mesh(const TetraMeshOptions& options, SimplexMesh& mesh,
                                                Progress& progress);
  [[nodiscard]] Result<TetraSurfaceReport> extract_surface(const TetraSurfaceOptions& options,
                                                           Surface& surface, Progress& progress);
  [[nodiscard]] Result<TetraSurfaceReport> extract_section(const TetraSectionOptions& options,
                                                           Surface& surface, Progress& progress);
  [[nodiscard]] Result<TetraSurfaceReport> extract_boundary(const TetraMeshOptions& options,
                                                            Surface& surface, Progress& progress);

  /// Nodes applied and undone for all answers so far.
  [[nodiscard]] std::uint64_t n_updates() const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace lode
