#include "lode/io/raw_volume.h"

#include "lode/io/deflated_samples.h"
#include "lode/io/image_grid.h"
#include "lode/io/text.h"

namespace lode::io {

Result<Image> read_raw(const std::string& path, const RawLayout& layout,
                       const SampleStorage& storage) {
  LODE_TRY(const InputFilePtr file, InputFile::open(path));
  const std::array<std::int64_t, 3> counts = {layout.dims[0], layout.dims[1], layout.dims[2]};
  LODE_TRY(const Index3 dims, checked_dims(path, counts));
  const bool is_compressed = to_lower(path).ends_with(".gz");
  Image image{.path = path,
              .format = is_compressed ? "raw, gzip" : "raw",
              .frame_note = "raw files name no frame",
              .grid = {},
              .fields = {},
              .tally = file->tally()};
  LODE_TRY(
      image.grid,
      make_grid(path, GridFrame{.dims = dims, .spacing = layout.spacing, .origin = layout.origin}));
  ImageField field;
  LODE_TRY(field.layout, interleaved_layout(path, dims, layout.type, 1, 1));
  field.layout.byte_order = layout.byte_order;
  const std::uint64_t n_bytes = field.layout.n_bytes;
  if (!is_compressed && n_bytes != file->size())
    return fail("{}: expected {} bytes ({} x {} x {} samples of {}), the file has {}", path,
                n_bytes, dims[0], dims[1], dims[2], name_of(layout.type), file->size());
  field.load = [file, n_bytes, is_compressed, storage] {
    return is_compressed ? load_inflated({.file = file, .n_bytes = n_bytes}, storage)
                         : make_file_store(file, 0, n_bytes);
  };
  image.fields.push_back(std::move(field));
  return image;
}

}  // namespace lode::io
