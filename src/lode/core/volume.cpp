#include "lode/core/volume.h"

#include <cstring>
#include <new>

#include "lode/core/out_of_memory.h"

namespace lode {
namespace {

class MemorySource final : public VolumeSource {
 public:
  explicit MemorySource(const Volume& volume) : volume_(volume) {}

  const VolumeInfo& info() const override { return volume_.info; }

  Result<void> read(const IndexBox& box, std::span<std::byte> out) override {
    const RegularGrid& grid = volume_.info.grid;
    LODE_EXPECTS(grid.index_box().contains(box));
    const std::size_t size = size_of(volume_.info.type);
    const std::size_t row_bytes = static_cast<std::size_t>(box.dims()[0]) * size;
    LODE_EXPECTS(out.size() == static_cast<std::size_t>(box.n_samples()) * size);
    if (box.is_empty()) return {};
    std::byte* to = out.data();
    for (std::int32_t z = box.lower[2]; z < box.upper[2]; ++z)
      for (std::int32_t y = box.lower[1]; y < box.upper[1]; ++y) {
        const std::int64_t first =
            (std::int64_t{z} * grid.dims[1] + y) * grid.dims[0] + box.lower[0];
        std::memcpy(to, volume_.samples.data() + static_cast<std::size_t>(first) * size, row_bytes);
        to += row_bytes;
      }
    return {};
  }

 private:
  const Volume& volume_;
};

}  // namespace

std::unique_ptr<VolumeSource> make_memory_source(const Volume& volume) {
  return std::make_unique<MemorySource>(volume);
}

Result<Volume> read_all(VolumeSource& source) try {
  Volume volume{source.info(), {}};
  const IndexBox box = volume.info.grid.index_box();
  volume.samples.resize(static_cast<std::size_t>(box.n_samples()) * size_of(volume.info.type));
  LODE_CHECK(source.read(box, volume.samples));
  return volume;
} catch (const std::bad_alloc&) {
  return out_of_memory("read the samples");
}

}  // namespace lode
