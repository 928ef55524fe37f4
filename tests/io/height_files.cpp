#include "tests/io/height_files.h"

#include <gtest/gtest.h>
#include <ogr_srs_api.h>

namespace lode::io::test {
namespace {

void describe(GDALDatasetH dataset, const RasterFile& raster) {
  if (raster.is_point) GDALSetMetadataItem(dataset, "AREA_OR_POINT", "Point", nullptr);
  if (raster.geotransform) {
    std::array<double, 6> g = *raster.geotransform;
    EXPECT_EQ(GDALSetGeoTransform(dataset, g.data()), CE_None);
  }
  if (raster.epsg != 0 || !raster.crs.empty()) {
    const std::string text =
        raster.crs.empty() ? "EPSG:" + std::to_string(raster.epsg) : raster.crs;
    OGRSpatialReferenceH crs = OSRNewSpatialReference(nullptr);
    EXPECT_EQ(OSRSetFromUserInput(crs, text.c_str()), OGRERR_NONE);
    EXPECT_EQ(GDALSetSpatialRef(dataset, crs), CE_None);
    OSRDestroySpatialReference(crs);
  }
}

void fill_bands(GDALDatasetH dataset, const RasterFile& raster) {
  for (int b = 1; b <= raster.n_bands; ++b) {
    GDALRasterBandH band = GDALGetRasterBand(dataset, b);
    std::vector<double> samples = raster.samples;
    for (double& z : samples) z += 1000 * (b - 1);
    if (raster.nodata) GDALSetRasterNoDataValue(band, *raster.nodata);
    if (raster.scale != 1) GDALSetRasterScale(band, raster.scale);
    if (raster.offset != 0) GDALSetRasterOffset(band, raster.offset);
    if (!raster.unit.empty()) GDALSetRasterUnitType(band, raster.unit.c_str());
    EXPECT_EQ(GDALRasterIO(band, GF_Write, 0, 0, raster.n_columns, raster.n_rows, samples.data(),
                           raster.n_columns, raster.n_rows, GDT_Float64, 0, 0),
              CE_None);
    if (raster.nodata64) GDALSetRasterNoDataValueAsInt64(band, *raster.nodata64);
    if (!raster.int64) continue;
    std::int64_t first = *raster.int64;
    EXPECT_EQ(GDALRasterIO(band, GF_Write, 0, 0, 1, 1, &first, 1, 1, GDT_Int64, 0, 0), CE_None);
  }
}

}  // namespace

void write_raster(const std::string& path, const RasterFile& raster, const char* driver) {
  GDALAllRegister();
  const bool is_tiff = std::string(driver) == "GTiff";
  const std::array<const char*, 2> compressed{
      raster.is_signed_byte ? "PIXELTYPE=SIGNEDBYTE" : "COMPRESS=DEFLATE", nullptr};
  GDALDatasetH dataset = GDALCreate(GDALGetDriverByName(is_tiff ? "GTiff" : "MEM"), path.c_str(),
                                    raster.n_columns, raster.n_rows, raster.n_bands, raster.type,
                                    raster.is_compressed || raster.is_signed_byte
                                        ? const_cast<char**>(compressed.data())
                                        : nullptr);
  ASSERT_NE(dataset, nullptr);
  describe(dataset, raster);
  fill_bands(dataset, raster);
  const std::array<const char*, 3> lossless{"QUALITY=100", "REVERSIBLE=YES", nullptr};
  const bool is_jpeg = std::string(driver) == "JP2OpenJPEG";
  if (!is_tiff)
    GDALClose(GDALCreateCopy(GDALGetDriverByName(driver), path.c_str(), dataset, 0,
                             is_jpeg ? const_cast<char**>(lossless.data()) : nullptr, nullptr,
                             nullptr));
  GDALClose(dataset);
}

}  // namespace lode::io::test
