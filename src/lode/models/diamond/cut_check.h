#pragma once

#include <string>

#include "lode/core/progress.h"
#include "lode/models/diamond/extract.h"

namespace lode::diamond {

/// What the promises of an isosurface query come to, sample by sample.
struct CutReport {
  double achieved_error = 0;      ///< Largest stored error of a leaf that may hold the surface.
  double largest_difference = 0;  ///< Largest |F - F'| found at a sample of such a leaf.
  std::uint64_t n_active = 0;     ///< Leaves whose range meets the isovalue.
  std::uint64_t n_active_samples = 0;
  std::uint64_t n_pruned_samples = 0;  ///< Samples (once per simplex) outside those leaves.
  std::uint64_t n_too_far = 0;         ///< Samples where |F - F'| exceeds the leaf's stored error.
  std::uint64_t n_lost = 0;            ///< Pruned simplices with samples on both sides.
  std::string worst;                   ///< Where, when something is wrong.
};

/// Repeats a query, with its wanted nodes, simplex by simplex and compares with every sample: F' is
/// within the stored error on every leaf that may hold the surface, and no simplex that was left
/// aside holds any of it. Shares the stored attributes with the extraction, but neither its
/// selection nor its traversals. Simplices that holes remove hold no surface and are passed over.
template <int D>
[[nodiscard]] Result<CutReport> check_cut(const Model<D>& model, const IsosurfaceQuery& query,
                                          Progress& progress);

}  // namespace lode::diamond
