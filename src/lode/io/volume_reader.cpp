#include "lode/io/volume_reader.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <new>
#include <system_error>

#include "lode/core/out_of_memory.h"
#include "lode/io/dicom.h"
#include "lode/io/image.h"
#include "lode/io/image_source.h"
#include "lode/io/metaimage.h"
#include "lode/io/nifti.h"
#include "lode/io/nrrd.h"
#include "lode/io/raw_volume.h"
#include "lode/io/sample_storage.h"
#include "lode/io/text.h"
#include "lode/io/vtk_legacy.h"
#include "lode/io/vtk_xml_image.h"
#include "lode/io/zarr_volume.h"

namespace lode::io {
namespace {

constexpr std::string_view kVolumeExtensions =
    ".nrrd .nhdr .mha .mhd .nii .nii.gz .hdr .img .vti .vtr .vtk, a Zarr directory, and .raw "
    ".raw.gz with --dims and --type";
/// What others read, and may be meant.
constexpr std::string_view kOtherFiles =
    "a mesh of cells (.vtu .vts .vtk .msh .mesh; by lode-vtk-import Exodus II, CGNS, EnSight, "
    "OpenFOAM, PLOT3D, .pvtu .pvts .vtm), a raster of heights (.tif .asc .hgt .png .dem .bil .flt "
    ".dt0 .dt1 .dt2 .img .jp2 .sdat .grd .bt .nc) or scattered points (.las .xyz .txt .csv)";

using Reader = Result<Image> (*)(const std::string& path, const SampleStorage& storage);

/// The reader of a self-describing format, by extension; none for bare samples.
Reader reader_of(const std::string& path) {
  struct Entry {
    std::string_view extension;
    Reader reader;
  };
  constexpr std::array<Entry, 13> kReaders = {{
      {".nrrd", read_nrrd},
      {".nhdr", read_nrrd},
      {".mha", read_metaimage},
      {".mhd", read_metaimage},
      {".nii", read_nifti},
      {".nii.gz", read_nifti},
      {".hdr", read_nifti},
      {".hdr.gz", read_nifti},
      {".img", read_nifti},
      {".img.gz", read_nifti},
      {".vti", read_vtk_xml_image},
      {".vtr", read_vtk_xml_image},
      {".vtk", read_vtk_legacy},
  }};
  const std::string lower = to_lower(path);
  for (const Entry& entry : kReaders)
    if (lower.ends_with(entry.extension)) return entry.reader;
  return nullptr;
}

bool is_raw_path(const std::string& path) {
  const std::string lower = to_lower(path);
  return lower.ends_with(".raw") || lower.ends_with(".raw.gz");
}

Result<Image> read_image(const std::string& path, const ReadOptions& options) {
  const Reader reader = reader_of(path);
  const SampleStorage storage = storage_of(options);
  if (reader != nullptr && !options.raw) return reader(path, storage);
  // A missing file is the more useful complaint than a wrong extension.
  LODE_TRY(const InputFilePtr file, InputFile::open(path));
  if (reader != nullptr)
    return fail(
        "{}: this format describes itself; --dims, --type and the like are for bare samples", path);
  if (options.raw) return read_raw(path, *options.raw, storage);
  if (is_raw_path(path))
    return fail("{}: a raw file does not describe itself; give --dims X,Y,Z and --type", path);
  if (auto dicom = refuse_dicom(path)) return *dicom;
  return fail("{}: expected a volume ({}), or where they are taken {}, got extension {}", path,
              kVolumeExtensions, kOtherFiles,
              in_quotes(std::filesystem::path(path).extension().string()));
}

/// Keeps what third parties and the file system library throw inside this room.
template <typename T, typename F>
Result<T> guarded(const std::string& path, F&& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return out_of_memory("read the file", path);
  } catch (const std::exception& exception) {
    return fail("{}: cannot be read: {}", path, exception.what());
  }
}

}  // namespace

bool is_volume_path(const std::string& path) {
  std::error_code status;
  return reader_of(path) != nullptr || is_raw_path(path) ||
         std::filesystem::is_directory(path, status);
}

Result<std::unique_ptr<VolumeSource>> open_volume(const std::string& path,
                                                  const ReadOptions& options) {
  using Source = std::unique_ptr<VolumeSource>;
  return guarded<Source>(path, [&]() -> Result<Source> {
    if (std::filesystem::is_directory(path)) return open_zarr(path, options);
    LODE_TRY(const Image image, read_image(path, options));
    return make_image_source(image, options);
  });
}

Result<FileDescription> describe_volume(const std::string& path, const ReadOptions& options) {
  return guarded<FileDescription>(path, [&]() -> Result<FileDescription> {
    if (std::filesystem::is_directory(path)) return describe_zarr(path, options);
    LODE_TRY(const Image image, read_image(path, options));
    const ImageField* field = &image.fields.front();
    if (options.field) {
      LODE_TRY(field, choose_field(image, options));
    }
    FileDescription description{
        .format = image.format,
        .frame_note = image.frame_note,
        .fields = {},
        .grid = image.grid,
        .type = field->layout.type,
        .units = chosen_units({image.length_unit, field->value_unit}, options)};
    for (const ImageField& each : image.fields) description.fields.push_back(each.name);
    description.n_components = static_cast<int>(field->layout.n_components);
    description.n_times = static_cast<int>(field->layout.n_times);
    return description;
  });
}

}  // namespace lode::io
