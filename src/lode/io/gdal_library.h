#pragma once

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_vsi.h>
#include <gdal.h>
#include <gdal_utils.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include "lode/core/result.h"

namespace lode::io {

/// The functions of GDAL that Lode calls. The library and the hundred others that it brings are
/// loaded when the first raster is read, not with the program.
struct GdalLibrary {
  decltype(&GDALAllRegister) register_all = nullptr;
  decltype(&GDALOpenEx) open = nullptr;
  decltype(&GDALClose) close = nullptr;
  decltype(&GDALIdentifyDriverEx) identify = nullptr;
  decltype(&GDALGetRasterXSize) n_columns = nullptr;
  decltype(&GDALGetRasterYSize) n_rows = nullptr;
  decltype(&GDALGetRasterCount) n_bands = nullptr;
  decltype(&GDALGetRasterBand) band = nullptr;
  decltype(&GDALGetRasterDataType) type = nullptr;
  decltype(&GDALGetDataTypeName) type_name = nullptr;
  decltype(&GDALGetBlockSize) block_size = nullptr;
  decltype(&GDALGetMetadataItem) metadata = nullptr;
  decltype(&GDALGetRasterNoDataValue) nodata = nullptr;
  decltype(&GDALGetRasterNoDataValueAsInt64) nodata_int64 = nullptr;
  decltype(&GDALGetRasterNoDataValueAsUInt64) nodata_uint64 = nullptr;
  decltype(&GDALGetMaskFlags) mask_flags = nullptr;
  decltype(&GDALGetMaskBand) mask_band = nullptr;
  decltype(&GDALGetRasterScale) scale = nullptr;
  decltype(&GDALGetRasterOffset) offset = nullptr;
  decltype(&GDALGetRasterUnitType) unit = nullptr;
  decltype(&GDALGetGeoTransform) geotransform = nullptr;
  decltype(&GDALGetProjectionRef) projection = nullptr;
  decltype(&GDALGetDatasetDriver) driver = nullptr;
  decltype(&GDALGetDriverShortName) driver_name = nullptr;
  decltype(&GDALSetCacheMax64) set_cache = nullptr;
  decltype(&GDALRasterIO) read = nullptr;  ///< And write.
  decltype(&GDALWarpAppOptionsNew) new_warp_options = nullptr;
  decltype(&GDALWarpAppOptionsFree) free_warp_options = nullptr;
  decltype(&GDALWarp) warp = nullptr;
  decltype(&GDALDatasetGetLayerCount) n_layers = nullptr;
  decltype(&GDALDatasetGetLayer) layer = nullptr;
  decltype(&OGR_L_GetName) layer_name = nullptr;
  decltype(&OGR_L_GetSpatialRef) layer_crs = nullptr;
  decltype(&OGR_L_GetNextFeature) next_feature = nullptr;
  decltype(&OGR_F_GetFID) feature_number = nullptr;
  decltype(&OGR_F_GetGeometryRef) geometry = nullptr;
  decltype(&OGR_G_GetLinearGeometry) linear_geometry = nullptr;
  decltype(&OGR_G_DestroyGeometry) destroy_geometry = nullptr;
  decltype(&OGR_G_GetGeometryType) geometry_type = nullptr;
  decltype(&OGR_GT_Flatten) flat_type = nullptr;
  decltype(&OGR_GT_HasZ) has_heights = nullptr;
  decltype(&OGR_G_GetGeometryName) geometry_name = nullptr;
  decltype(&OGR_G_GetGeometryCount) n_parts = nullptr;
  decltype(&OGR_G_GetGeometryRef) part = nullptr;
  decltype(&OGR_G_GetPointCount) n_points = nullptr;
  decltype(&OGR_G_GetPoints) points = nullptr;
  decltype(&OSRIsSame) is_same_crs = nullptr;
  decltype(&OSRIsSameEx) is_same_crs_but = nullptr;
  decltype(&OCTNewCoordinateTransformation) new_transformation = nullptr;
  decltype(&OCTDestroyCoordinateTransformation) destroy_transformation = nullptr;
  decltype(&OCTTransform) transform = nullptr;
  decltype(&OCTTransformEx) transform_each = nullptr;  ///< And says which are done.
  decltype(&OCTClone) clone_transformation = nullptr;
  decltype(&OCTNewCoordinateTransformationOptions) new_way_options = nullptr;
  decltype(&OCTDestroyCoordinateTransformationOptions) destroy_way_options = nullptr;
  decltype(&OCTCoordinateTransformationOptionsSetBallparkAllowed) set_guesses = nullptr;
  decltype(&OCTNewCoordinateTransformationEx) new_transformation_by = nullptr;
  decltype(&GDALSetGeoTransform) set_geotransform = nullptr;
  decltype(&GDALSetSpatialRef) set_crs = nullptr;
  decltype(&GDALSetMetadataItem) set_metadata = nullptr;
  decltype(&GDALSetRasterNoDataValue) set_nodata = nullptr;
  decltype(&GDALSetRasterUnitType) set_unit = nullptr;
  decltype(&GDALSetDescription) set_description = nullptr;
  decltype(&OSRNewSpatialReference) new_crs = nullptr;
  decltype(&OSRDestroySpatialReference) destroy_crs = nullptr;
  decltype(&OSRImportFromWkt) import_wkt = nullptr;
  decltype(&OSRImportFromEPSG) import_epsg = nullptr;
  decltype(&OSRSetCompoundCS) set_compound = nullptr;
  decltype(&OSRIsVertical) is_vertical = nullptr;
  decltype(&OSRIsCompound) is_compound = nullptr;
  decltype(&OSRGetAxesCount) n_axes = nullptr;
  decltype(&OSRStripVertical) strip_vertical = nullptr;  ///< Of compound CRS.
  decltype(&OSRDemoteTo2D) strip_height = nullptr;       ///< Of those with three axes.
  decltype(&OSRExportToWkt) export_wkt = nullptr;
  decltype(&VSIFree) release = nullptr;  ///< What export_wkt() made.
  decltype(&OSRSetAxisMappingStrategy) set_axis_order = nullptr;
  decltype(&OSRIsGeographic) is_geographic = nullptr;
  decltype(&OSRIsGeocentric) is_geocentric = nullptr;
  decltype(&OSRIsProjected) is_projected = nullptr;
  decltype(&OSRIsLocal) is_local = nullptr;
  decltype(&OSRGetAttrValue) attribute = nullptr;
  decltype(&OSRGetSemiMajor) semi_major = nullptr;
  decltype(&OSRGetInvFlattening) inverse_flattening = nullptr;
  decltype(&OSRGetPrimeMeridian) prime_meridian = nullptr;
  decltype(&OSRGetAngularUnits) angular_units = nullptr;
  decltype(&OSRGetLinearUnits) linear_units = nullptr;
  decltype(&GDALGetDriverByName) driver_named = nullptr;
  decltype(&GDALCreate) create = nullptr;
  decltype(&GDALDatasetCreateLayer) new_layer = nullptr;
  decltype(&GDALDatasetStartTransaction) start_transaction = nullptr;
  decltype(&GDALDatasetCommitTransaction) commit_transaction = nullptr;
  decltype(&OGR_Fld_Create) new_field = nullptr;
  decltype(&OGR_Fld_Destroy) destroy_field = nullptr;
  decltype(&OGR_L_CreateField) add_field = nullptr;
  decltype(&OGR_L_GetLayerDefn) layer_definition = nullptr;
  decltype(&OGR_L_CreateFeature) add_feature = nullptr;
  decltype(&OGR_F_Create) new_feature = nullptr;
  decltype(&OGR_F_Destroy) destroy_feature = nullptr;
  decltype(&OGR_F_SetFieldDouble) set_number = nullptr;  ///< Of integers, too.
  decltype(&OGR_F_SetFieldString) set_text = nullptr;
  decltype(&OGR_F_SetFieldNull) set_null = nullptr;
  decltype(&OGR_F_SetGeometryDirectly) set_geometry = nullptr;
  decltype(&OGR_G_CreateGeometry) new_geometry = nullptr;
  decltype(&OGR_G_AddGeometryDirectly) add_geometry = nullptr;
  decltype(&OGR_G_SetPoints) set_points = nullptr;
  decltype(&CPLSetThreadLocalConfigOption) set_option = nullptr;
  decltype(&CPLGetLastErrorType) last_error_kind = nullptr;
  decltype(&CPLPushErrorHandler) push_error_handler = nullptr;
  decltype(&CPLPopErrorHandler) pop_error_handler = nullptr;
  CPLErrorHandler quiet_handler = nullptr;
  decltype(&CPLErrorReset) reset_errors = nullptr;
  decltype(&CPLGetLastErrorMsg) last_error = nullptr;

  /// Loads and starts it once; any thread. Fails where it is not installed.
  [[nodiscard]] static Result<const GdalLibrary*> get();
};

}  // namespace lode::io
