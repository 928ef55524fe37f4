#include "crs.h"

#include <cpl_conv.h>
#include <gdal.h>
#include <ogr_srs_api.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <type_traits>
#include <vector>

#include "axes.h"

namespace lode::raster_import {
namespace {

using Crs =
    std::unique_ptr<std::remove_pointer_t<OGRSpatialReferenceH>, void (*)(OGRSpatialReferenceH)>;

Crs new_crs() { return {OSRNewSpatialReference(nullptr), OSRDestroySpatialReference}; }

GridMapping mapping_of(const Crs& crs) {
  char* text = nullptr;
  const bool is_written = OSRExportToWkt(crs.get(), &text) == OGRERR_NONE && text != nullptr;
  const std::string wkt = is_written ? text : "";
  CPLFree(text);
  if (wkt.empty())
    throw std::runtime_error(
        "expected a grid_mapping whose CRS can be written as WKT, got another: --crs says the CRS");
  GridMapping mapping;
  mapping.wkt = wkt;
  for (char& c : mapping.wkt)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  mapping.is_geographic = OSRIsGeographic(crs.get()) != 0;
  if (!mapping.is_geographic) mapping.metres_a_unit = OSRGetLinearUnits(crs.get(), nullptr);
  return mapping;
}

/// The variable that grid_mapping names, which may be followed by names of coordinates.
std::optional<Variable> mapping_variable(const Variable& variable) {
  const std::string said = text_attribute(variable.group, variable.id, "grid_mapping");
  if (said.empty()) return {};
  const std::string name = said.substr(0, said.find_first_of(": "));
  for (int at = variable.group;;) {
    Variable found{.group = at, .name = name};
    if (nc_inq_varid(at, name.c_str(), &found.id) == NC_NOERR) return found;
    int parent = 0;
    if (nc_inq_grp_parent(at, &parent) != NC_NOERR) break;
    at = parent;
  }
  throw std::runtime_error("expected the variable '" + name +
                           "', which grid_mapping names, got none: --crs says the CRS");
}

std::optional<int> epsg_of(const Variable& mapping) {
  std::string code = text_attribute(mapping.group, mapping.id, "epsg_code");
  const nc_type type = attribute_shape(mapping.group, mapping.id, "epsg_code").type;
  if (type != NC_NAT && type != NC_CHAR && type != NC_STRING) {
    const std::vector<double> numbers = numbers_attribute(mapping.group, mapping.id, "epsg_code");
    constexpr double kMost = 1e6;
    if (!numbers.empty() && numbers[0] > 0 && numbers[0] < kMost)
      return static_cast<int>(numbers[0]);
  }
  if (code.starts_with("EPSG:")) code.erase(0, 5);
  int number = 0;
  const auto [end, status] = std::from_chars(code.data(), code.data() + code.size(), number);
  if (code.empty() || status != std::errc() || end != code.data() + code.size()) return {};
  return number;
}

/// A file of memory alone, with a path.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(::memfd_create("lode-crs", MFD_CLOEXEC)) {
    if (descriptor_ < 0) throw std::runtime_error("expected a file of memory, got none");
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { ::close(descriptor_); }
  [[nodiscard]] std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

/// In types that classic files have.
void copy_attributes(const Variable& from, int file, int to) {
  int n = 0;
  check(nc_inq_varnatts(from.group, from.id, &n), "attributes");
  for (int i = 0; i < n; ++i) {
    std::array<char, NC_MAX_NAME + 1> name{};
    check(nc_inq_attname(from.group, from.id, i, name.data()), "attributes");
    const AttributeShape shape = attribute_shape(from.group, from.id, name.data());
    if (shape.is_text()) {
      const std::string text = text_attribute(from.group, from.id, name.data());
      check(nc_put_att_text(file, to, name.data(), text.size(), text.c_str()), "attributes");
    } else if (shape.type <= NC_UINT64 && std::string_view(name.data()) != "_FillValue") {
      const std::vector<double> numbers = numbers_attribute(from.group, from.id, name.data());
      check(nc_put_att_double(file, to, name.data(), NC_DOUBLE, numbers.size(), numbers.data()),
            "attributes");
    }
  }
}

/// A small file that says of a CRS what a variable's does: GDAL need not look at that, which may be
/// damaged, and does not open CDF-5.
void write_alike(const Variable& variable, const Variable& mapping, const std::string& path) {
  constexpr std::array<double, 2> kPlaces{0, 1};
  int file = -1;
  check(nc_create(path.c_str(), NC_CLOBBER, &file), "a file of memory");
  std::array<int, 2> dimensions{};
  std::array<int, 2> axes{};
  for (std::size_t i = 0; i < 2; ++i) {
    const int dimension = variable.dimensions[variable.rank() - 2 + i];
    const Variable axis = coordinate_of(variable.group, dimension);
    check(nc_def_dim(file, axis.name.c_str(), 2, &dimensions[i]), "a file of memory");
    check(nc_def_var(file, axis.name.c_str(), NC_DOUBLE, 1, &dimensions[i], &axes[i]),
          "a file of memory");
    copy_attributes(axis, file, axes[i]);
  }
  int heights = -1;
  int where = -1;
  check(nc_def_var(file, "lode_heights", NC_SHORT, 2, dimensions.data(), &heights),
        "a file of memory");
  check(nc_def_var(file, "lode_mapping", NC_INT, 0, nullptr, &where), "a file of memory");
  check(nc_put_att_text(file, heights, "grid_mapping", 12, "lode_mapping"), "a file of memory");
  copy_attributes(mapping, file, where);
  check(nc_enddef(file), "a file of memory");
  for (const int axis : axes)
    check(nc_put_var_double(file, axis, kPlaces.data()), "a file of memory");
  check(nc_close(file), "a file of memory");
}

/// Of CF's attributes; empty where GDAL understands them not.
std::string wkt_by_gdal(const Variable& variable, const Variable& mapping) {
  constexpr std::array<const char*, 2> kDrivers{"netCDF", nullptr};
  const MemoryFile alike;
  write_alike(variable, mapping, alike.path());
  const std::string name = "NETCDF:\"" + alike.path() + "\":lode_heights";
  GDALDatasetH dataset = GDALOpenEx(name.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY,
                                    kDrivers.data(), nullptr, nullptr);
  if (dataset == nullptr) return {};
  const char* const wkt = GDALGetProjectionRef(dataset);
  std::string text = wkt == nullptr ? "" : wkt;
  GDALClose(dataset);
  return text;
}

bool import_wkt(const Crs& crs, std::string text) {
  char* at = text.data();
  return !text.empty() && OSRImportFromWkt(crs.get(), &at) == OGRERR_NONE;
}

}  // namespace

GridMapping read_grid_mapping(const Variable& variable) {
  const auto mapping = mapping_variable(variable);
  if (!mapping) return {};
  const Crs crs = new_crs();
  for (const char* name : {"crs_wkt", "spatial_ref"})
    if (import_wkt(crs, text_attribute(mapping->group, mapping->id, name))) return mapping_of(crs);
  if (const auto epsg = epsg_of(*mapping))
    if (OSRImportFromEPSG(crs.get(), *epsg) == OGRERR_NONE) return mapping_of(crs);
  if (import_wkt(crs, wkt_by_gdal(variable, *mapping))) return mapping_of(crs);
  throw std::runtime_error(
      "expected a grid_mapping with crs_wkt, spatial_ref or CF's attributes, got one that is not "
      "understood, '" +
      mapping->name + "': --crs says the CRS");
}

}  // namespace lode::raster_import
