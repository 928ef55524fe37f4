#include "lode/io/gdal_library.h"

#include <dlfcn.h>

#include <string>

namespace lode::io {
namespace {

/// Finds functions in a library that is open; remembers the first that is missing.
class Finder {
 public:
  explicit Finder(void* library) : library_(library) {}

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

void find_rasters(Finder& finder, GdalLibrary& gdal) {
  finder.find(gdal.register_all, "GDALAllRegister");
  finder.find(gdal.open, "GDALOpenEx");
  finder.find(gdal.close, "GDALClose");
  finder.find(gdal.identify, "GDALIdentifyDriverEx");
  finder.find(gdal.n_columns, "GDALGetRasterXSize");
  finder.find(gdal.n_rows, "GDALGetRasterYSize");
  finder.find(gdal.n_bands, "GDALGetRasterCount");
  finder.find(gdal.geotransform, "GDALGetGeoTransform");
  finder.find(gdal.projection, "GDALGetProjectionRef");
  finder.find(gdal.driver, "GDALGetDatasetDriver");
  finder.find(gdal.driver_name, "GDALGetDriverShortName");
  finder.find(gdal.push_error_handler, "CPLPushErrorHandler");
  finder.find(gdal.pop_error_handler, "CPLPopErrorHandler");
  finder.find(gdal.quiet_handler, "CPLQuietErrorHandler");
  finder.find(gdal.reset_errors, "CPLErrorReset");
  finder.find(gdal.last_error, "CPLGetLastErrorMsg");
}

void find_bands(Finder& finder, GdalLibrary& gdal) {
  finder.find(gdal.band, "GDALGetRasterBand");
  finder.find(gdal.type, "GDALGetRasterDataType");
  finder.find(gdal.type_name, "GDALGetDataTypeName");
  finder.find(gdal.block_size, "GDALGetBlockSize");
  finder.find(gdal.metadata, "GDALGetMetadataItem");
  finder.find(gdal.nodata, "GDALGetRasterNoDataValue");
  finder.find(gdal.nodata_int64, "GDALGetRasterNoDataValueAsInt64");
  finder.find(gdal.nodata_uint64, "GDALGetRasterNoDataValueAsUInt64");
  finder.find(gdal.mask_flags, "GDALGetMaskFlags");
  finder.find(gdal.mask_band, "GDALGetMaskBand");
  finder.find(gdal.scale, "GDALGetRasterScale");
  finder.find(gdal.offset, "GDALGetRasterOffset");
  finder.find(gdal.unit, "GDALGetRasterUnitType");
  finder.find(gdal.set_cache, "GDALSetCacheMax64");
  finder.find(gdal.read, "GDALRasterIO");
  finder.find(gdal.new_warp_options, "GDALWarpAppOptionsNew");
  finder.find(gdal.free_warp_options, "GDALWarpAppOptionsFree");
  finder.find(gdal.warp, "GDALWarp");
}

void find_raster_output(Finder& finder, GdalLibrary& gdal) {
  finder.find(gdal.set_geotransform, "GDALSetGeoTransform");
  finder.find(gdal.set_crs, "GDALSetSpatialRef");
  finder.find(gdal.set_metadata, "GDALSetMetadataItem");
  finder.find(gdal.set_nodata, "GDALSetRasterNoDataValue");
  finder.find(gdal.set_unit, "GDALSetRasterUnitType");
  finder.find(gdal.set_description, "GDALSetDescription");
}

void find_crs(Finder& finder, GdalLibrary& gdal) {
  finder.find(gdal.new_crs, "OSRNewSpatialReference");
  finder.find(gdal.destroy_crs, "OSRDestroySpatialReference");
  finder.find(gdal.import_wkt, "OSRImportFromWkt");
  finder.find(gdal.import_epsg, "OSRImportFromEPSG");
  finder.find(gdal.set_compound, "OSRSetCompoundCS");
  finder.find(gdal.is_vertical, "OSRIsVertical");
  finder.find(gdal.is_compound, "OSRIsCompound");
  finder.find(gdal.n_axes, "OSRGetAxesCount");
  finder.find(gdal.strip_vertical, "OSRStripVertical");
  finder.find(gdal.strip_height, "OSRDemoteTo2D");
  finder.find(gdal.export_wkt, "OSRExportToWkt");
  finder.find(gdal.release, "VSIFree");
  finder.find(gdal.set_axis_order, "OSRSetAxisMappingStrategy");
  finder.find(gdal.is_geographic, "OSRIsGeographic");
  finder.find(gdal.is_geocentric, "OSRIsGeocentric");
  finder.find(gdal.is_projected, "OSRIsProjected");
  finder.find(gdal.is_local, "OSRIsLocal");
  finder.find(gdal.attribute, "OSRGetAttrValue");
  finder.find(gdal.semi_major, "OSRGetSemiMajor");
  finder.find(gdal.inverse_flattening, "OSRGetInvFlattening");
  finder.find(gdal.prime_meridian, "OSRGetPrimeMeridian");
  finder.find(gdal.angular_units, "OSRGetAngularUnits");
  finder.find(gdal.linear_units, "OSRGetLinearUnits");
}

void find_vectors(Finder& finder, GdalLibrary& gdal) {
  finder.find(gdal.driver_named, "GDALGetDriverByName");
  finder.find(gdal.create, "GDALCreate");
  finder.find(gdal.new_layer, "GDALDatasetCreateLayer");
  finder.find(gdal.start_transaction, "GDALDatasetStartTransaction");
  finder.find(gdal.commit_transaction, "GDALDatasetCommitTransaction");
  finder.find(gdal.new_field, "OGR_Fld_Create");
  finder.find(gdal.destroy_field, "OGR_Fld_Destroy");
  finder.find(gdal.add_field, "OGR_L_CreateField");
  finder.find(gdal.layer_definition, "OGR_L_GetLayerDefn");
  finder.find(gdal.add_feature, "OGR_L_CreateFeature");
  finder.find(gdal.new_feature, "OGR_F_Create");
  finder.find(gdal.destroy_feature, "OGR_F_Destroy");
  finder.find(gdal.set_number, "OGR_F_SetFieldDouble");
  finder.find(gdal.set_text, "OGR_F_SetFieldString");
  finder.find(gdal.set_null, "OGR_F_SetFieldNull");
  finder.find(gdal.set_geometry, "OGR_F_SetGeometryDirectly");
  finder.find(gdal.new_geometry, "OGR_G_CreateGeometry");
  finder.find(gdal.add_geometry, "OGR_G_AddGeometryDirectly");
  finder.find(gdal.set_points, "OGR_G_SetPoints");
  finder.find(gdal.set_option, "CPLSetThreadLocalConfigOption");
  finder.find(gdal.last_error_kind, "CPLGetLastErrorType");
}

void find_vector_input(Finder& finder, GdalLibrary& gdal) {
  finder.find(gdal.n_layers, "GDALDatasetGetLayerCount");
  finder.find(gdal.layer, "GDALDatasetGetLayer");
  finder.find(gdal.layer_name, "OGR_L_GetName");
  finder.find(gdal.layer_crs, "OGR_L_GetSpatialRef");
  finder.find(gdal.next_feature, "OGR_L_GetNextFeature");
  finder.find(gdal.feature_number, "OGR_F_GetFID");
  finder.find(gdal.geometry, "OGR_F_GetGeometryRef");
  finder.find(gdal.linear_geometry, "OGR_G_GetLinearGeometry");
  finder.find(gdal.destroy_geometry, "OGR_G_DestroyGeometry");
  finder.find(gdal.geometry_type, "OGR_G_GetGeometryType");
  finder.find(gdal.flat_type, "OGR_GT_Flatten");
  finder.find(gdal.has_heights, "OGR_GT_HasZ");
  finder.find(gdal.geometry_name, "OGR_G_GetGeometryName");
  finder.find(gdal.n_parts, "OGR_G_GetGeometryCount");
  finder.find(gdal.part, "OGR_G_GetGeometryRef");
  finder.find(gdal.n_points, "OGR_G_GetPointCount");
  finder.find(gdal.points, "OGR_G_GetPoints");
  finder.find(gdal.is_same_crs, "OSRIsSame");
  finder.find(gdal.is_same_crs_but, "OSRIsSameEx");
  finder.find(gdal.new_transformation, "OCTNewCoordinateTransformation");
  finder.find(gdal.destroy_transformation, "OCTDestroyCoordinateTransformation");
  finder.find(gdal.transform, "OCTTransform");
  finder.find(gdal.transform_each, "OCTTransformEx");
  finder.find(gdal.clone_transformation, "OCTClone");
  finder.find(gdal.new_way_options, "OCTNewCoordinateTransformationOptions");
  finder.find(gdal.destroy_way_options, "OCTDestroyCoordinateTransformationOptions");
  finder.find(gdal.set_guesses, "OCTCoordinateTransformationOptionsSetBallparkAllowed");
  finder.find(gdal.new_transformation_by, "OCTNewCoordinateTransformationEx");
}

Result<GdalLibrary> load() {
  void* library = dlopen(LODE_GDAL_LIBRARY, RTLD_LAZY | RTLD_LOCAL);
  if (library == nullptr) {
    const char* reason = dlerror();
    return fail("expected the library {} for rasters and CRS (Debian: libgdal-dev), got: {}",
                LODE_GDAL_LIBRARY, reason == nullptr ? "nothing" : reason);
  }
  GdalLibrary gdal;
  Finder finder(library);
  find_rasters(finder, gdal);
  find_bands(finder, gdal);
  find_raster_output(finder, gdal);
  find_crs(finder, gdal);
  find_vectors(finder, gdal);
  find_vector_input(finder, gdal);
  if (!finder.missing().empty())
    return fail("expected {} to have {}, got a library without it", LODE_GDAL_LIBRARY,
                finder.missing());
  gdal.push_error_handler(gdal.quiet_handler);
  gdal.register_all();
  gdal.pop_error_handler();
  return gdal;
}

}  // namespace

Result<const GdalLibrary*> GdalLibrary::get() {
  static const Result<GdalLibrary> kLibrary = load();
  if (!kLibrary) return kLibrary.error();
  return &kLibrary.value();
}

}  // namespace lode::io
