#include "gdal_file.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <gdal.h>
#include <gdal_utils.h>
#include <strings.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "free_space.h"

namespace lode::raster_import {
namespace {

/// The drivers that are asked: of files, or of those and sidecars of their names; and of pictures
/// that tiles of some are. None for networks or databases, nor what opens whatever it names.
constexpr std::array<std::string_view, 28> kAsked{
    "NITF",    "GPKG",     "GRIB",     "AIG",    "ERS",      "RST",   "GTX",
    "LCP",     "Terragen", "Leveller", "HF2",    "PCRaster", "ILWIS", "ISIS3",
    "ISIS2",   "PDS",      "VICAR",    "SIGDEM", "BLX",      "ISG",   "KRO",
    "USGSDEM", "AAIGrid",  "GTiff",    "PNG",    "JPEG",     "WEBP",  "JP2OpenJPEG"};

struct CloseDataset {
  void operator()(void* dataset) const { GDALClose(dataset); }
};
using Dataset = std::unique_ptr<void, CloseDataset>;

[[noreturn]] void refuse(const std::string& what) {
  std::string said = CPLGetLastErrorMsg();
  throw std::runtime_error(what + (said.empty() ? "nothing that it knows" : said));
}

void leave_drivers(std::span<const std::string_view> left) {
  for (int i = GDALGetDriverCount(); i-- > 0;)
    if (GDALDriverH driver = GDALGetDriver(i);
        std::find(left.begin(), left.end(), GDALGetDriverShortName(driver)) == left.end())
      GDALDeregisterDriver(driver);
}

void set_up_gdal() {
  CPLSetConfigOption("GDAL_DRIVER_PATH", "disable");
  // Files beside it are looked for by name.
  CPLSetConfigOption("GDAL_DISABLE_READDIR_ON_OPEN", "TRUE");
  CPLSetConfigOption("GDAL_TIFF_INTERNAL_MASK", "YES");
  GDALAllRegister();
  // What a file names is not asked of networks, whoever opens it.
  CPLSetConfigOption("CPL_VSIL_CURL_ALLOWED_EXTENSIONS", ".none");
  leave_drivers(kAsked);
}

/// Some formats name other files, and GDAL has names for what is no file: none here has such.
void check_names(const std::string& path) {
  constexpr std::size_t kHead = std::size_t{1} << 20;
  std::string head(kHead, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  if (head.find("/vsi") != std::string::npos)
    throw std::runtime_error("expected a raster that names files alone, got one with '/vsi'");
}

bool is_packed(const std::string& path) {
  return path.size() > 3 && ::strcasecmp(path.c_str() + path.size() - 3, ".gz") == 0;
}

Dataset open_raster(const std::string& path) {
  CPLErrorReset();
  const std::string name = (is_packed(path) ? "/vsigzip/" : "") + path;
  // Numbers in text may have more digits than float32.
  constexpr std::array<const char*, 2> kWide{"DATATYPE=Float64", nullptr};
  Dataset dataset(GDALOpenEx(name.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, nullptr,
                             is_packed(path) ? kWide.data() : nullptr, nullptr));
  if (!dataset) refuse("expected a raster that GDAL reads, got: ");
  if (GDALGetRasterCount(dataset.get()) > 0) return dataset;
  const int n_parts = CSLCount(GDALGetMetadata(dataset.get(), "SUBDATASETS")) / 2;
  throw std::runtime_error(
      "expected a file with one raster, got " + std::to_string(n_parts) +
      (n_parts > 1 ? ": gdal_translate makes a GeoTIFF of one of them (gdalinfo names them)" : ""));
}

/// Of all files that it is made of. Throws where some are elsewhere.
std::uint64_t bytes_of_files(const std::string& path, GDALDatasetH dataset) {
  namespace fs = std::filesystem;
  std::error_code status;
  std::uint64_t n = fs::file_size(path, status);
  const fs::path folder = fs::path(path).parent_path().lexically_normal();
  char** const files = GDALGetFileList(dataset);
  for (int i = 0; i < CSLCount(files); ++i) {
    const std::string_view listed = files[i];
    if (listed.starts_with("/vsigzip/")) continue;
    const fs::path file = fs::absolute(listed, status).lexically_normal();
    if (file.parent_path() != folder && file.parent_path().parent_path() != folder) {
      const std::string text = file.string();
      CSLDestroy(files);
      throw std::runtime_error("expected a raster in one directory, got one that names " + text);
    }
    if (file != fs::path(path).lexically_normal()) n += fs::file_size(file, status);
  }
  CSLDestroy(files);
  return n;
}

std::uint64_t check_samples(GDALDatasetH dataset, GDALRasterBandH band, std::uint64_t n_files) {
  const GDALDataType type = GDALGetRasterDataType(band);
  if (GDALDataTypeIsComplex(type) != 0 || type == GDT_Unknown)
    throw std::runtime_error(std::string("expected real numbers, got ") +
                             GDALGetDataTypeName(type));
  const auto n_columns = static_cast<std::uint64_t>(GDALGetRasterXSize(dataset));
  const auto n_rows = static_cast<std::uint64_t>(GDALGetRasterYSize(dataset));
  const std::uint64_t n_bytes =
      n_columns * n_rows * static_cast<std::uint64_t>(GDALGetDataTypeSizeBytes(type));
  // As deflate has it at most; what is small may be emptier.
  constexpr std::uint64_t kRatio = 1032;
  constexpr std::uint64_t kSmall = std::uint64_t{512} << 20;
  if (n_bytes > kSmall && n_bytes / kRatio > n_files)
    throw std::runtime_error("expected files that can hold " + std::to_string(n_columns) + " x " +
                             std::to_string(n_rows) + " samples, got " + std::to_string(n_files) +
                             " bytes");
  return n_bytes;
}

struct Told {
  const std::function<void(double, std::uint64_t)>& progress;
  std::uint64_t n_bytes;
};

int tell(double fraction, const char* /*message*/, void* told) {
  const auto& to = *static_cast<Told*>(told);
  to.progress(fraction, to.n_bytes);
  return TRUE;
}

void translate(GDALDatasetH dataset, int band, const std::string& output, Told& told) {
  const std::string number = std::to_string(band);
  const std::array<const char*, 7> words{
      "-of", "GTiff", "-b", number.c_str(), "-co", "BIGTIFF=IF_SAFER", nullptr};
  const std::unique_ptr<GDALTranslateOptions, decltype(&GDALTranslateOptionsFree)> options(
      GDALTranslateOptionsNew(const_cast<char**>(words.data()), nullptr),
      &GDALTranslateOptionsFree);
  GDALTranslateOptionsSetProgress(options.get(), &tell, &told);
  CPLErrorReset();
  int misused = FALSE;
  const Dataset copy(GDALTranslate(output.c_str(), dataset, options.get(), &misused));
  if (!copy) refuse("expected samples that GDAL can copy, got: ");
  GDALFlushCache(copy.get());
  if (CPLGetLastErrorType() >= CE_Failure) refuse("expected samples that GDAL can copy, got: ");
}

}  // namespace

GdalFacts copy_by_gdal(const std::string& path, const Choice& choice, const std::string& output,
                       const std::function<void(double, std::uint64_t)>& progress) {
  check_names(path);
  set_up_gdal();
  const Dataset dataset = open_raster(path);
  const std::uint64_t n_files = bytes_of_files(path, dataset.get());
  const int n_bands = GDALGetRasterCount(dataset.get());
  const std::size_t band = choice.layer.value_or(1);
  if (band > static_cast<std::size_t>(n_bands))
    throw std::runtime_error("expected a band from 1 to " + std::to_string(n_bands) + ", got " +
                             std::to_string(band));
  const auto number = static_cast<int>(band);
  const std::uint64_t n_bytes =
      check_samples(dataset.get(), GDALGetRasterBand(dataset.get(), number), n_files);
  check_space(output, n_bytes);
  GdalFacts facts;
  facts.format = GDALGetDriverShortName(GDALGetDatasetDriver(dataset.get()));
  if (const char* crs = GDALGetProjectionRef(dataset.get())) facts.crs = crs;
  const char* pixel = GDALGetMetadataItem(dataset.get(), "AREA_OR_POINT", nullptr);
  facts.is_point = pixel != nullptr && std::string_view(pixel) == "Point";
  if (n_bands > 1 && !choice.layer)
    facts.notes.push_back("it has " + std::to_string(n_bands) +
                          " bands, of which the first is read: --band says another one");
  Told told{progress, n_bytes};
  // Before GDAL writes a file it asks all drivers whether there is one of theirs, and some look at
  // what lies beside: of a descriptor in /proc that is a pipe that never ends. Pictures, of which
  // other formats have tiles, are told by their first bytes.
  leave_drivers(std::span(kAsked).last(5));
  translate(dataset.get(), number, output, told);
  return facts;
}

}  // namespace lode::raster_import
