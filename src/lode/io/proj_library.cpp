#include "lode/io/proj_library.h"

#include <dlfcn.h>

#include <string>

namespace lode::io {
namespace {

class ProjFinder {
 public:
  explicit ProjFinder(void* library) : library_(library) {}

  template <typename Function>
  void find(Function& function, const char* name) {
    function = reinterpret_cast<Function>(dlsym(library_, name));
    if (function == nullptr && missing_.empty()) missing_ = name;
  }
  [[nodiscard]] const std::string& missing() const { return missing_; }

 private:
  void* library_;
  std::string missing_;
};

void find_crs(ProjFinder& finder, ProjLibrary& proj) {
  finder.find(proj.new_context, "proj_context_create");
  finder.find(proj.destroy_context, "proj_context_destroy");
  finder.find(proj.set_log_level, "proj_log_level");
  finder.find(proj.last_error, "proj_context_errno");
  finder.find(proj.error_text, "proj_context_errno_string");
  finder.find(proj.create, "proj_create");
  finder.find(proj.clone, "proj_clone");
  finder.find(proj.destroy, "proj_destroy");
  finder.find(proj.type, "proj_get_type");
  finder.find(proj.name, "proj_get_name");
  finder.find(proj.as_wkt, "proj_as_wkt");
  finder.find(proj.is_equivalent, "proj_is_equivalent_to");
  finder.find(proj.source_crs, "proj_get_source_crs");
  finder.find(proj.sub_crs, "proj_crs_get_sub_crs");
  finder.find(proj.coordinate_system, "proj_crs_get_coordinate_system");
  finder.find(proj.n_axes, "proj_cs_get_axis_count");
  finder.find(proj.axis_info, "proj_cs_get_axis_info");
  finder.find(proj.compound, "proj_create_compound_crs");
  finder.find(proj.with_height, "proj_crs_promote_to_3D");
  finder.find(proj.without_height, "proj_crs_demote_to_2D");
}

void find_operations(ProjFinder& finder, ProjLibrary& proj) {
  finder.find(proj.new_factory, "proj_create_operation_factory_context");
  finder.find(proj.destroy_factory, "proj_operation_factory_context_destroy");
  finder.find(proj.set_grid_use, "proj_operation_factory_context_set_grid_availability_use");
  finder.find(proj.set_ballpark,
              "proj_operation_factory_context_set_allow_ballpark_transformations");
  finder.find(proj.set_criterion, "proj_operation_factory_context_set_spatial_criterion");
  finder.find(proj.set_area, "proj_operation_factory_context_set_area_of_interest");
  finder.find(proj.operations, "proj_create_operations");
  finder.find(proj.n_listed, "proj_list_get_count");
  finder.find(proj.listed, "proj_list_get");
  finder.find(proj.destroy_list, "proj_list_destroy");
  finder.find(proj.is_instantiable, "proj_coordoperation_is_instantiable");
  finder.find(proj.is_ballpark, "proj_coordoperation_has_ballpark_transformation");
  finder.find(proj.accuracy, "proj_coordoperation_get_accuracy");
  finder.find(proj.n_grids, "proj_coordoperation_get_grid_used_count");
  finder.find(proj.grid, "proj_coordoperation_get_grid_used");
  finder.find(proj.with_x_first, "proj_normalize_for_visualization");
  finder.find(proj.between, "proj_create_crs_to_crs_from_pj");
  finder.find(proj.transform_bounds, "proj_trans_bounds");
  finder.find(proj.transform, "proj_trans_generic");
}

Result<ProjLibrary> load_proj() {
  void* library = dlopen(LODE_PROJ_LIBRARY, RTLD_LAZY | RTLD_LOCAL);
  if (library == nullptr) {
    const char* reason = dlerror();
    return fail("expected the library {} for vertical CRS (Debian: libproj-dev), got: {}",
                LODE_PROJ_LIBRARY, reason == nullptr ? "nothing" : reason);
  }
  ProjLibrary proj;
  ProjFinder finder(library);
  find_crs(finder, proj);
  find_operations(finder, proj);
  if (!finder.missing().empty())
    return fail("expected {} to have {}, got a library without it", LODE_PROJ_LIBRARY,
                finder.missing());
  return proj;
}

}  // namespace

Result<const ProjLibrary*> ProjLibrary::get() {
  static const Result<ProjLibrary> kLibrary = load_proj();
  if (!kLibrary) return kLibrary.error();
  return &kLibrary.value();
}

Result<Proj> Proj::make() {
  LODE_TRY(const ProjLibrary* library, ProjLibrary::get());
  Proj proj(library);
  if (proj.context_ == nullptr) return fail("expected PROJ to start, got nothing from it");
  library->set_log_level(proj.context(), PJ_LOG_NONE);
  return proj;
}

const char* Proj::reason() const {
  const int error = library_->last_error(context());
  const char* text = error == 0 ? nullptr : library_->error_text(context(), error);
  return text == nullptr ? "PROJ says no more" : text;
}

}  // namespace lode::io
