#pragma once

#include <proj.h>
// Compound CRS and those with heights above ellipsoids, as GDAL makes them.
#include <proj_experimental.h>

#include <memory>

#include "lode/core/result.h"

namespace lode::io {

/// The functions of PROJ that Lode calls, and those that free what they make. Loaded when a
/// vertical CRS is first asked of, as GDAL is; GDAL uses the same library.
struct ProjLibrary {
  decltype(&proj_context_create) new_context = nullptr;
  decltype(&proj_context_destroy) destroy_context = nullptr;
  decltype(&proj_log_level) set_log_level = nullptr;
  decltype(&proj_context_errno) last_error = nullptr;
  decltype(&proj_context_errno_string) error_text = nullptr;
  decltype(&proj_create) create = nullptr;
  decltype(&proj_clone) clone = nullptr;
  decltype(&proj_destroy) destroy = nullptr;
  decltype(&proj_get_type) type = nullptr;
  decltype(&proj_get_name) name = nullptr;
  decltype(&proj_as_wkt) as_wkt = nullptr;
  decltype(&proj_is_equivalent_to) is_equivalent = nullptr;
  decltype(&proj_get_source_crs) source_crs = nullptr;
  decltype(&proj_crs_get_sub_crs) sub_crs = nullptr;
  decltype(&proj_crs_get_coordinate_system) coordinate_system = nullptr;
  decltype(&proj_cs_get_axis_count) n_axes = nullptr;
  decltype(&proj_cs_get_axis_info) axis_info = nullptr;
  decltype(&proj_create_compound_crs) compound = nullptr;
  decltype(&proj_crs_promote_to_3D) with_height = nullptr;
  decltype(&proj_crs_demote_to_2D) without_height = nullptr;
  decltype(&proj_create_operation_factory_context) new_factory = nullptr;
  decltype(&proj_operation_factory_context_destroy) destroy_factory = nullptr;
  decltype(&proj_operation_factory_context_set_grid_availability_use) set_grid_use = nullptr;
  decltype(&proj_operation_factory_context_set_allow_ballpark_transformations) set_ballpark =
      nullptr;
  decltype(&proj_operation_factory_context_set_spatial_criterion) set_criterion = nullptr;
  decltype(&proj_operation_factory_context_set_area_of_interest) set_area = nullptr;
  decltype(&proj_create_operations) operations = nullptr;
  decltype(&proj_list_get_count) n_listed = nullptr;
  decltype(&proj_list_get) listed = nullptr;
  decltype(&proj_list_destroy) destroy_list = nullptr;
  decltype(&proj_coordoperation_is_instantiable) is_instantiable = nullptr;
  decltype(&proj_coordoperation_has_ballpark_transformation) is_ballpark = nullptr;
  decltype(&proj_coordoperation_get_accuracy) accuracy = nullptr;
  decltype(&proj_coordoperation_get_grid_used_count) n_grids = nullptr;
  decltype(&proj_coordoperation_get_grid_used) grid = nullptr;
  decltype(&proj_normalize_for_visualization) with_x_first = nullptr;
  decltype(&proj_create_crs_to_crs_from_pj) between = nullptr;
  decltype(&proj_trans_bounds) transform_bounds = nullptr;
  decltype(&proj_trans_generic) transform = nullptr;

  /// Loads it once; any thread. Fails where it is not installed.
  [[nodiscard]] static Result<const ProjLibrary*> get();
};

/// One thread's part of PROJ, and what is made in it.
class Proj {
 public:
  struct Destroy {
    const ProjLibrary* library = nullptr;
    void operator()(PJ* object) const { library->destroy(object); }
  };
  /// A CRS or a transformation.
  using Object = std::unique_ptr<PJ, Destroy>;

  [[nodiscard]] static Result<Proj> make();

  [[nodiscard]] const ProjLibrary& library() const { return *library_; }
  [[nodiscard]] PJ_CONTEXT* context() const { return context_.get(); }
  /// Null stays null.
  [[nodiscard]] Object own(PJ* object) const { return Object(object, Destroy{library_}); }
  /// What PROJ said last.
  [[nodiscard]] const char* reason() const;

 private:
  struct DestroyContext {
    const ProjLibrary* library = nullptr;
    void operator()(PJ_CONTEXT* context) const { library->destroy_context(context); }
  };

  explicit Proj(const ProjLibrary* library)
      : library_(library), context_(library->new_context(), DestroyContext{library}) {}

  const ProjLibrary* library_;
  std::unique_ptr<PJ_CONTEXT, DestroyContext> context_;
};

}  // namespace lode::io
