#include "lode/io/image.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

namespace lode::io {
namespace {

class MemoryStore final : public SampleStore {
 public:
  explicit MemoryStore(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}

  Result<void> read(std::uint64_t offset, std::span<std::byte> out) override {
    LODE_EXPECTS(offset <= bytes_.size() && out.size() <= bytes_.size() - offset);
    if (!out.empty()) std::memcpy(out.data(), bytes_.data() + offset, out.size());
    return {};
  }

 private:
  std::vector<std::byte> bytes_;
};

class FileStore final : public SampleStore {
 public:
  FileStore(InputFilePtr file, std::uint64_t offset) : file_(std::move(file)), offset_(offset) {}

  Result<void> read(std::uint64_t offset, std::span<std::byte> out) override {
    return file_->read(offset_ + offset, out);
  }

 private:
  InputFilePtr file_;
  std::uint64_t offset_;
};

template <typename T>
void reverse_each(std::span<std::byte> bytes) {
  for (std::size_t i = 0; i + sizeof(T) <= bytes.size(); i += sizeof(T))
    std::reverse(bytes.data() + i, bytes.data() + i + sizeof(T));
}

}  // namespace

std::unique_ptr<SampleStore> make_memory_store(std::vector<std::byte> bytes) {
  return std::make_unique<MemoryStore>(std::move(bytes));
}

Result<std::unique_ptr<SampleStore>> make_file_store(InputFilePtr file, std::uint64_t offset,
                                                     std::uint64_t n_bytes) {
  if (file->size_from(offset) < n_bytes)
    return fail("{}: the header promises {} bytes of samples from offset {}, the file has {}",
                file->path(), n_bytes, offset, file->size_from(offset));
  return std::unique_ptr<SampleStore>(std::make_unique<FileStore>(std::move(file), offset));
}

Result<std::uint64_t> checked_n_bytes(const std::string& path, std::span<const std::int64_t> counts,
                                      std::size_t size) {
  constexpr std::uint64_t kMax = std::numeric_limits<std::int64_t>::max();
  std::uint64_t n_bytes = size;
  for (const std::int64_t count : counts) {
    if (count < 1) return fail("{}: expected sizes of at least 1, got {}", path, count);
    if (n_bytes > kMax / static_cast<std::uint64_t>(count))
      return fail("{}: the sizes in the header multiply to more than 2^63 bytes", path);
    n_bytes *= static_cast<std::uint64_t>(count);
  }
  return n_bytes;
}

Result<Index3> checked_dims(const std::string& path, std::span<const std::int64_t> counts) {
  LODE_EXPECTS(counts.size() == 3);
  // One less than int32 holds, so that an exclusive upper bound plus one still fits.
  constexpr std::int64_t kMaxDim = std::numeric_limits<std::int32_t>::max() - 1;
  Index3 dims;
  for (std::size_t i = 0; i < 3; ++i) {
    if (counts[i] < 1 || counts[i] > kMaxDim)
      return fail("{}: expected between 1 and {} samples along axis {}, got {}", path, kMaxDim,
                  "xyz"[i], counts[i]);
    dims[i] = static_cast<std::int32_t>(counts[i]);
  }
  return dims;
}

Result<SampleLayout> interleaved_layout(const std::string& path, const Index3& dims,
                                        ScalarType type, std::int64_t n_components,
                                        std::int64_t n_times) {
  const std::array<std::int64_t, 5> counts = {n_components, dims[0], dims[1], dims[2], n_times};
  SampleLayout layout;
  LODE_TRY(layout.n_bytes, checked_n_bytes(path, counts, size_of(type)));
  layout.type = type;
  layout.n_components = n_components;
  layout.n_times = n_times;
  layout.strides[0] = n_components;
  layout.strides[1] = layout.strides[0] * dims[0];
  layout.strides[2] = layout.strides[1] * dims[1];
  layout.time_stride = layout.strides[2] * dims[2];
  return layout;
}

void to_native(std::span<std::byte> bytes, ScalarType type, ByteOrder order) {
  const bool is_native =
      (order == ByteOrder::little) == (std::endian::native == std::endian::little);
  if (is_native) return;
  visit_scalar_type(type, [&]<typename T>() { reverse_each<T>(bytes); });
}

Result<std::vector<double>> read_doubles(SampleStore& store, ScalarType type, ByteOrder order,
                                         std::size_t n) {
  std::vector<std::byte> bytes(n * size_of(type));
  LODE_CHECK(store.read(0, bytes));
  to_native(bytes, type, order);
  std::vector<double> numbers(n);
  visit_scalar_type(type, [&]<typename T>() {
    for (std::size_t i = 0; i < n; ++i) {
      T number;
      std::memcpy(&number, bytes.data() + i * sizeof(T), sizeof(T));
      numbers[i] = static_cast<double>(number);
    }
  });
  return numbers;
}

}  // namespace lode::io
