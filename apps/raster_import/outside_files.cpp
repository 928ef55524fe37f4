#include "outside_files.h"

#include <hdf5.h>

#include <exception>
#include <stdexcept>
#include <utility>

namespace lode::raster_import {
namespace {

/// Of a kind that H5Xclose() closes.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  [[nodiscard]] hid_t id() const { return id_; }
  [[nodiscard]] bool is_open() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// What was found first, empty: nothing.
using Finding = std::string;

Finding finding_of_dataset(hid_t group, const char* name) {
  const Handle dataset(H5Dopen2(group, name, H5P_DEFAULT), H5Dclose);
  if (!dataset.is_open()) return "samples that cannot be opened";
  const Handle creation(H5Dget_create_plist(dataset.id()), H5Pclose);
  if (!creation.is_open()) return "samples that cannot be opened";
  if (H5Pget_external_count(creation.id()) != 0) return "samples that are stored in another file";
  if (H5Pget_layout(creation.id()) == H5D_VIRTUAL)
    return "samples that are put together from other files";
  return {};
}

/// HDF5 calls it from C, which nothing may be thrown through.
herr_t on_link(hid_t group, const char* name, const H5L_info_t* link, void* data) try {
  Finding& finding = *static_cast<Finding*>(data);
  std::string shown = name;
  if (link->type == H5L_TYPE_EXTERNAL) {
    finding = "a link to another file, '" + shown + "'";
  } else if (link->type == H5L_TYPE_HARD) {
    H5O_info_t object{};
    if (H5Oget_info_by_name2(group, name, &object, H5O_INFO_BASIC, H5P_DEFAULT) < 0) {
      finding = "an object that cannot be opened, '" + shown + "'";
    } else if (object.type == H5O_TYPE_DATASET) {
      finding = finding_of_dataset(group, name);
      if (!finding.empty()) finding += ", '" + shown + "'";
    }
  } else if (link->type != H5L_TYPE_SOFT) {
    finding = "a link of a kind that is not HDF5's own, '" + shown + "'";
  }
  return finding.empty() ? 0 : 1;
} catch (const std::exception&) {
  return -1;
}

}  // namespace

void check_outside_files(const std::string& path) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file.is_open())
    throw std::runtime_error(
        "expected a netCDF-4 file that is whole, got one that HDF5 cannot open");
  Finding finding;
  const herr_t status = H5Lvisit(file.id(), H5_INDEX_NAME, H5_ITER_NATIVE, on_link, &finding);
  if (!finding.empty())
    throw std::runtime_error("expected a netCDF-4 file that is whole in itself, got " + finding);
  if (status < 0)
    throw std::runtime_error("expected a netCDF-4 file that is whole, got damaged links");
}

}  // namespace lode::raster_import
